"""Where things fall in a picture."""

from __future__ import annotations

import numpy as np
import pytest

from cablecad.errors import UsageError
from cablecad.picture.camera import VIEWS, Margins, aim_camera, view_direction

BOX = np.array([[x, y, z] for x in (10.0, 40.0) for y in (-5.0, 15.0) for z in (100.0, 110.0)])
SIZE = (400, 300)


def camera_of(view: str, points: np.ndarray = BOX, margins: Margins | None = None):
    return aim_camera(points, view_direction(view), SIZE, margins or Margins(), depth_points=points)


@pytest.mark.parametrize("view", [*VIEWS, "1,2,3", "-0.2,0,-5", "1e-300,0,0", "1e300,1e300,0"])
def test_frame_of_the_camera(view):
    camera = camera_of(view)
    axes = np.stack([camera.right, camera.up, camera.toward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(camera.right, camera.up), camera.toward, atol=1e-12)
    assert camera.up[2] > -1e-12  # never upside down


@pytest.mark.parametrize(
    ("view", "right", "up"),
    [
        ("front", [1, 0, 0], [0, 0, 1]),
        ("back", [-1, 0, 0], [0, 0, 1]),
        ("right", [0, 1, 0], [0, 0, 1]),
        ("left", [0, -1, 0], [0, 0, 1]),
        ("top", [1, 0, 0], [0, 1, 0]),
        ("bottom", [-1, 0, 0], [0, 1, 0]),
    ],
)
def test_named_views_are_those_of_a_drawing(view, right, up):
    camera = camera_of(view)
    np.testing.assert_allclose(camera.right, right, atol=1e-15)
    np.testing.assert_allclose(camera.up, up, atol=1e-15)


def test_iso_sees_front_right_and_top():
    camera = camera_of("iso")
    assert camera.toward @ [0, -1, 0] == camera.toward @ [1, 0, 0] == camera.toward @ [0, 0, 1] > 0.5


@pytest.mark.parametrize("view", [*VIEWS, "1,2,3"])
def test_all_is_within_the_margins_and_fills_them(view):
    margins = Margins(left=0.1, right=0.2, top=0.05, bottom=0.15)
    x, y = camera_of(view, margins=margins).project(BOX).T
    room = (0.1 * 400, 0.8 * 400, 0.05 * 300, 0.85 * 300)
    slack = [x.min() - room[0], room[1] - x.max(), y.min() - room[2], room[3] - y.max()]
    assert min(slack) == pytest.approx(0.0, abs=1e-9)
    # In the middle of the room both ways.
    assert slack[0] == pytest.approx(slack[1], abs=1e-9)
    assert slack[2] == pytest.approx(slack[3], abs=1e-9)


def test_scale_holds_all_over():
    camera = camera_of("front")
    start, end = camera.project(np.array([[10.0, -5.0, 100.0], [40.0, 15.0, 100.0]]))
    assert (end - start) * camera.mm_per_pixel == pytest.approx([30.0, 0.0])


def test_single_point():
    camera = camera_of("iso", np.array([[1.0, 2.0, 3.0]]))
    assert np.isfinite(camera.project(BOX)).all()


@pytest.mark.parametrize("view", ["", "up", "1,2", "1,2,3,4", "0,0,0", "a,b,c", "nan,0,1", "inf,0,1", "ISO"])
def test_no_views(view):
    with pytest.raises(UsageError, match="give one of iso, front, back, top, bottom, right, left, or the direction"):
        view_direction(view)
