"""Pictures of scenes: what is where in them, asked of their pixels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from seen import likeness, near

from cablecad import Cable, Part, Pin, Port, Scene, load_scene
from cablecad.errors import InfeasibleError, UsageError
from cablecad.picture.palette import ALERT, GROUND
from cablecad.picture.render import render_scene

pytestmark = pytest.mark.usefixtures("draws")

SAMPLES = Path(__file__).parents[2] / "samples"
UP = (0, 0, 1)
ARCH = Cable("W1", 6.0, Port((0, 0, 0), UP), Port((0, 120, 0), UP), length=350.0, color="#0072b2")
"""In the plane x = 0, symmetric about y = 60."""

SMALL = (480, 300)


def picture_of(scene: Scene, path: Path, **options):
    picture = render_scene(scene, path, **{"size": SMALL, **options})
    return picture, picture.pixels / 255.0


# --- what is where ---------------------------------------------------------------------------------------------------


def test_the_cable_is_where_the_camera_says(tmp_path):
    """The camera of the tests' own: seen from the right, y goes to the right and z upwards, both to one scale."""
    picture, pixels = picture_of(Scene(cables=(ARCH,)), tmp_path / "a.png", view="right")
    blue = pixels[:, :, 2] - pixels[:, :, 0] > 0.15
    blue[:, :100] = False  # where the axes are
    rows, columns = np.nonzero(blue)
    from cablecad import solve

    solution = solve(ARCH)
    top = solution.points(2001)[:, 2].max() + 3.0
    scale = (rows.max() + 1 - rows.min()) / top  # from z = 0 to the highest point of the side
    assert 1.0 / scale == pytest.approx(picture.camera.mm_per_pixel, rel=0.02)
    low, high = picture.camera.project(np.array([[0.0, -3.0, 0.0], [0.0, 123.0, top]]))
    widest = np.abs(solution.points(2001)[:, 1] - 60.0).max() + 3.0
    left, right = picture.camera.project(np.array([[0.0, 60.0 - widest, 0.0], [0.0, 60.0 + widest, 0.0]]))[:, 0]
    np.testing.assert_allclose(
        [columns.min(), columns.max() + 1, rows.max() + 1, rows.min()], [left, right, low[1], high[1]], atol=2.0
    )


@pytest.mark.parametrize("view", ["iso", "right", "top", "3,-1,0.5"])
def test_the_marked_spot_is_the_tightest(tmp_path, view):
    """Where the curvature is greatest of many samples, projected here by hand: there the ring is."""
    from cablecad import solve

    solution = solve(ARCH)
    s = np.linspace(0.0, 350.0, 7001)
    at = s[np.argmax(np.abs(solution.curvature(s)))]
    picture, pixels = picture_of(Scene(cables=(ARCH,)), tmp_path / "a.png", view=view, curvature=True, size=(800, 500))
    spot, camera = picture.tightest, picture.camera
    assert (spot.cable, spot.arclength) == ("W1", pytest.approx(at, abs=0.05))
    assert spot.bend_radius == pytest.approx(1.0 / np.abs(solution.curvature(s)).max(), rel=1e-6)
    np.testing.assert_allclose(spot.position, solution.position(at)[0], atol=0.06)
    x, y = (
        (solution.position(at)[0] - camera.centre) @ axis / camera.mm_per_pixel for axis in (camera.right, camera.up)
    )
    place = np.array([400.0 + x, 250.0 - y])
    alert = near(pixels, ALERT, 0.25)
    em = 800 / 64.0
    angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)

    def ring_at(point: np.ndarray) -> float:
        """How much of a ring around a point has the mark's colour."""
        around = point + 0.8 * em * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        columns, rows = np.floor(around).astype(int).T
        return float(alert[rows.clip(0, 499), columns.clip(0, 799)].mean())

    assert ring_at(place) > 0.9
    assert max(ring_at(place + step) for step in 0.7 * em * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])) < 0.5


def test_of_many_cables_the_tightest_of_all_is_marked(tmp_path):
    scene = load_scene(SAMPLES / "loom.toml")
    picture, _ = picture_of(scene, tmp_path / "a.png", curvature=True)
    from cablecad import solve_many

    radii = {solution.cable.name: solution.bend_radius_min for solution in solve_many(scene.cables)}
    assert picture.tightest.cable == min(radii, key=radii.get)
    assert picture.tightest.bend_radius == min(radii.values())


def test_colours_are_the_cables_own(tmp_path):
    scene = load_scene(SAMPLES / "loom.toml")
    picture, pixels = picture_of(scene, tmp_path / "a.png", view="front", size=(800, 500))
    from cablecad import solve_many

    for solution in solve_many(scene.cables):
        column, row = picture.camera.project(solution.position(solution.length / 2.0))[0]
        patch = pixels[int(row) - 1 : int(row) + 2, int(column) - 1 : int(column) + 2].mean(axis=(0, 1))
        own = np.array(list(bytes.fromhex(solution.cable.color[1:]))) / 255.0
        # Light changes its brightness, not its hue.
        assert patch @ own / (np.linalg.norm(patch) * np.linalg.norm(own)) > 0.985


def test_curvature_is_dark_where_tight_and_light_where_gentle(tmp_path):
    picture, pixels = picture_of(
        Scene(cables=(ARCH,)), tmp_path / "a.png", view="right", curvature=True, size=(800, 500)
    )
    from cablecad import solve

    solution = solve(ARCH)
    s = np.linspace(20.0, 155.0, 28)  # clear of the ring
    columns, rows = np.floor(picture.camera.project(solution.position(s))).astype(int).T
    brightness = pixels[rows, columns] @ [0.2126, 0.7152, 0.0722]
    kappa = np.abs(solution.curvature(s))
    assert np.corrcoef(kappa, brightness)[0, 1] < -0.95


def test_ground_is_plain_and_nothing_touches_the_border(tmp_path):
    for name, view in (("connectors", "top"), ("crossed", "front"), ("figure6", "1,2,3")):
        _, pixels = picture_of(load_scene(SAMPLES / f"{name}.toml"), tmp_path / "a.png", view=view, curvature=True)
        border = np.concatenate(
            [
                pixels[:3].reshape(-1, 3),
                pixels[-3:].reshape(-1, 3),
                pixels[:, :3].reshape(-1, 3),
                pixels[:, -3:].reshape(-1, 3),
            ]
        )
        assert near(border[None], GROUND, 0.01).all()


def test_scale_bar_is_as_long_as_it_says(tmp_path):
    picture, pixels = picture_of(Scene(cables=(ARCH,)), tmp_path / "a.png", view="right", size=(1600, 1000))
    row = 1000 - round(2.2 * 25.0)
    columns = np.nonzero(pixels[row, 150:800].max(axis=1) < 0.35)[0]
    assert (columns.max() - columns.min()) * picture.camera.mm_per_pixel == pytest.approx(50.0, rel=0.03)


def test_cable_alone_fills_the_picture(tmp_path):
    scene = load_scene(SAMPLES / "loom.toml")
    whole, _ = picture_of(scene, tmp_path / "a.png")
    closer, pixels = picture_of(scene, tmp_path / "b.png", cables=["W3"])
    assert closer.camera.mm_per_pixel < 0.6 * whole.camera.mm_per_pixel
    hue = pixels[:, :, 0] - pixels[:, :, 2]
    assert not ((hue > 0.5) & (pixels[:, :, 0] > 0.7) & (pixels[:, :, 1] < 0.4)).sum() > 200  # W2, orange, is not there


def test_cables_without_a_colour_get_different_ones(tmp_path):
    cables = tuple(Cable(f"W{i}", 12.0, Pin((0, 40 * i, 0)), Pin((200, 40 * i, 0)), length=200.0) for i in range(3))
    picture, pixels = picture_of(Scene(cables=cables), tmp_path / "a.png", view="top")
    found = [
        pixels[tuple(np.floor(picture.camera.project(np.array([[100.0, 40.0 * i, 0.0]]))[0][::-1]).astype(int))]
        for i in range(3)
    ]
    apart = [np.abs(found[i] - found[j]).max() for i, j in ((0, 1), (0, 2), (1, 2))]
    assert min(apart) > 0.2


def test_same_bytes_twice(tmp_path):
    for name in ("a.png", "b.png"):
        render_scene(load_scene(SAMPLES / "connectors.toml"), tmp_path / name, size=SMALL, curvature=True)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


# --- odd scenes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_scenes_of_any_size_look_the_same(tmp_path, size):
    def arch(unit):
        ends = (Port((0, 0, 0), UP), Port((0, 120 * unit, 0), UP))
        return Scene(cables=(Cable("W1", 6 * unit, *ends, length=350 * unit, color="#0072b2"),))

    _, usual = picture_of(arch(1.0), tmp_path / "a.png")
    _, other = picture_of(arch(size), tmp_path / "b.png")
    assert likeness(usual, other) > 0.99


def test_scene_far_from_the_origin_looks_the_same(tmp_path):
    far = Cable("W1", 6.0, Port((1e7, 0, 1e7), UP), Port((1e7, 120, 1e7), UP), length=350.0, color="#0072b2")
    _, usual = picture_of(Scene(cables=(ARCH,)), tmp_path / "a.png")
    _, other = picture_of(Scene(cables=(far,)), tmp_path / "b.png")
    assert np.abs(usual - other).max() < 0.1


def test_parts_alone(tmp_path):
    scene = Scene(parts=(Part("bracket", SAMPLES / "parts" / "bracket.step"),))
    picture, pixels = picture_of(scene, tmp_path / "a.png", curvature=True)
    assert picture.tightest is None
    assert 0.1 < (~near(pixels, GROUND, 0.01)).mean() < 0.7


def test_no_such_shape_no_picture(tmp_path):
    short = Cable("W1", 6.0, Pin((0, 0, 0)), Pin((0, 120, 0)), length=100.0)
    with pytest.raises(InfeasibleError, match="cable W1: length 100 mm"):
        render_scene(
            Scene(cables=(ARCH.__class__("W0", 6.0, ARCH.start, ARCH.end, length=350.0), short)), tmp_path / "a.png"
        )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"view": "above"}, "give one of iso"),
        ({"size": (100, 100)}, "200 to 8192"),
        ({"cables": ["W7"]}, "there is no such cable in the scene; it has W1"),
    ],
)
def test_what_cannot_be_meant(tmp_path, options, said):
    with pytest.raises(UsageError, match=said):
        render_scene(Scene(cables=(ARCH,)), tmp_path / "a.png", **options)
    with pytest.raises(UsageError, match=r"must end in \.png"):
        render_scene(Scene(cables=(ARCH,)), tmp_path / "a.jpg")


def test_thin_cables_are_lines_in_their_own_colour(tmp_path):
    """A thousandth of a millimetre thick or two millimetres: neither gaps nor outlines that leave nothing of it."""
    ends = Port((0, 0, 0), UP), Port((0, 1200, 0), UP)
    for diameter in (0.001, 2.0):
        cable = Cable("W1", diameter, *ends, length=3500.0, color="#d00000")
        picture, pixels = picture_of(Scene(cables=(cable,)), tmp_path / "a.png", view="right", size=(800, 500))
        red = pixels[:, :, 0] - pixels[:, :, 1] > 0.15
        red[:, :100] = False  # where the axes are
        from cablecad import solve

        places = np.rint(picture.camera.project(solve(cable).points(400))).astype(int)
        near = [red[row - 2 : row + 3, column - 2 : column + 3].any() for column, row in places]
        assert all(near)
        assert pixels[red].mean(axis=0)[0] > 0.55


def test_a_cable_far_smaller_than_a_pixel_is_a_dot(tmp_path):
    large = Cable("W1", 4.0, Port((0, 0, 0), UP), Port((0, 120, 0), UP), length=350.0)
    small = Cable("W2", 1e-4, Port((0, 200, 0), UP), Port((0, 200.0012, 0), UP), length=0.0035, color="#d00000")
    picture, pixels = picture_of(Scene(cables=(large, small)), tmp_path / "a.png", view="right")
    column, row = np.rint(picture.camera.project(np.array([[0.0, 200.0, 0.0]]))[0]).astype(int)
    patch = pixels[row - 3 : row + 4, column - 3 : column + 4]
    assert (patch[:, :, 0] - patch[:, :, 1]).max() > 0.1


def test_names_that_cannot_be_set_are_told_by_number_and_long_ones_shortened():
    from cablecad.picture.render import Spot, _mark_words

    def words(name):
        return _mark_words(Spot(name, 2, 175.0, 50.0, np.zeros(3)), 3)[1]

    assert words("W2") == "W2, s = 175 mm"
    assert words("\u7535\u7f06") == "cable 2, s = 175 mm"
    assert words("x" * 70) == "x" * 25 + "..., s = 175 mm"
