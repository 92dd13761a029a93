"""What a user gets: the sample built by the command, read back by Open Cascade, measured against mpmath."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from oracle import PinnedOracle

from cablecad.model import Material
from cablecad.pipeline import run_build
from cablecad.scene import load_scene

pytest.importorskip("OCP", reason="solids need the kernel")

SAMPLE = Path(__file__).parents[2] / "samples" / "connectors.toml"


def side_points(solid, along: int, around: int) -> np.ndarray:
    """Points of the read-back side face at parameters off the knots, shape (along * around, 3)."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_SurfaceType
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    from cablecad.brep.kernel import subshapes

    sides = [BRepAdaptor_Surface(TopoDS.Face(face)) for face in subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE)]
    (side,) = (face for face in sides if face.GetType() == GeomAbs_SurfaceType.GeomAbs_BSplineSurface)
    u = np.linspace(side.FirstUParameter(), side.LastUParameter(), around, endpoint=False) + 0.01
    v = np.linspace(side.FirstVParameter(), side.LastVParameter(), along)
    points = [side.Value(a, b) for a in u for b in v]
    return np.array([(p.X(), p.Y(), p.Z()) for p in points])


def distance_to_curve(points: np.ndarray, oracle: PinnedOracle) -> np.ndarray:
    """Distance of points to the oracle's centreline in the x-z plane, by Newton on exact positions from 401 nodes.

    Between nodes the exact curve is its quintic Hermite interpolant, whose error, h^6 kappa^5 / 46080, is 1e-17 mm.
    """
    import mpmath as mp

    nodes = np.linspace(0.0, float(oracle.length), 401)
    places, tangents, bends = [], [], []
    for s in nodes:
        u = oracle.omega * mp.mpf(float(s)) - oracle.K
        sn, cn, dn = (mp.ellipfun(name, u, m=oracle.m) for name in ("sn", "cn", "dn"))
        # psi falls from +beta_0 to -beta_0: the arch towards +y of the oracle.
        cosine, sine, kappa = 1 - 2 * oracle.m * sn**2, -2 * oracle.k * sn * dn, -2 * oracle.k * oracle.omega * cn
        places.append([float(x) for x in oracle.point(float(s))])
        tangents.append([float(cosine), float(sine)])
        bends.append([float(-kappa * sine), float(kappa * cosine)])
    from scipy.interpolate import BPoly

    curve = BPoly.from_derivatives(nodes, np.stack([places, tangents, bends], axis=1))
    flat = points[:, [0, 2]]
    s = nodes[np.argmin(((flat[:, None] - np.array(places)[None]) ** 2).sum(axis=2), axis=1)]
    for _ in range(6):
        off = flat - curve(s)
        tangent, bend = curve(s, 1), curve(s, 2)
        step = (off * tangent).sum(axis=1) / ((tangent**2).sum(axis=1) - (off * bend).sum(axis=1))
        s = np.clip(s + step, 0.0, nodes[-1])
    off = flat - curve(s)
    return np.sqrt((off**2).sum(axis=1) + points[:, 1] ** 2)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_side_of_the_read_back_solid(tolerance: float, tmp_path: Path) -> None:
    from cablecad.brep.step import read_tree

    scene = load_scene(SAMPLE)
    (cable,) = scene.cables
    path = tmp_path / "built.step"
    from dataclasses import replace

    run = run_build(replace(scene, tolerance=tolerance), path)
    assert run.exit_code == 0
    (root,) = read_tree(path)
    parts, cables = root.children
    assert (root.name, parts.name, cables.name) == ("two connectors", "parts", "cables")
    assert [part.occurrence for part in parts.children] == ["left connector", "right connector"]
    assert all([child.name for child in part.children] == ["housing", "gasket"] for part in parts.children)
    assert all(child.color is not None for part in parts.children for child in part.children)
    (built,) = cables.children
    assert built.name == "W1"
    np.testing.assert_allclose(
        built.color or built.occurrence_color, (0x2B / 255, 0x6C / 255, 0xB0 / 255, 1.0), atol=1e-4
    )
    # The oracle solves the scene on its own: length and chord to k.
    import mpmath as mp

    chord = mp.mpf(cable.end.position[0])
    m = mp.findroot(lambda m: 2 * mp.ellipe(m) / mp.ellipk(m) - 1 - chord / 350, 0.03)
    oracle = PinnedOracle(350.0, m=m)
    distance = distance_to_curve(side_points(built.shape, along=331, around=7), oracle)
    deviation = np.abs(distance - cable.diameter / 2).max()
    assert deviation <= tolerance
    assert deviation <= run.report()["cables"][0]["solid"]["deviation"] * 1.01 + 1e-12
    # Two cables as long as the deviation lets them be: pi r^2 L to 1e-7 where the tolerance allows it.
    assert built.volume == pytest.approx(math.pi * 4.0 * 350.0, rel=max(1e-7, 2 * tolerance))
    assert Material(youngs_modulus=3890.0, poissons_ratio=0.25) == cable.material
