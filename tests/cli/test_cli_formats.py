"""`build` into GLB, STL and BREP: read by programs that know nothing of cablecad."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path

import numpy as np
import pytest
from loom import PVC, cable, names, part, quoted, scene, write

trimesh = pytest.importorskip("trimesh")

SAMPLES = Path(__file__).parents[2] / "samples"
LOOM = SAMPLES / "loom.toml"
FORMATS = ["glb", "stl", "brep"]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The loom in every format, by the command line."""
    from cablecad.cli.group import cablecad
    from cablecad.cli.session import run_command

    folder = tmp_path_factory.mktemp("formats")
    for kind in FORMATS:
        assert run_command(cablecad, ["build", str(LOOM), "-o", str(folder / f"loom.{kind}"), "-q"]) == 0
    return folder


def linear(color: str) -> np.ndarray:
    """Of ``#rrggbb``, in linear light: IEC 61966-2-1."""
    values = np.array(list(bytes.fromhex(color[1:7]))) / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def chunk(data: bytes) -> dict:
    """The JSON of a GLB file, whose header is checked on the way."""
    magic, version, length = struct.unpack("<4sII", data[:12])
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack("<I4s", data[12:20])
    assert kind == b"JSON"
    assert size % 4 == 0
    return json.loads(data[20 : 20 + size])


# --- GLB -------------------------------------------------------------------------------------------------------------


def test_glb_has_names_colours_and_places(built):
    loaded = trimesh.load(built / "loom.glb")
    assert {"loom", "parts", "cables", "bracket", "W1", "W1 start", "W3 end"} <= set(loaded.graph.nodes)
    for name, color in (("W1", "#0072b2"), ("W2", "#d55e00"), ("W3", "#009e73")):
        _, geometry = loaded.graph[name]
        material = loaded.geometry[geometry].visual.material
        np.testing.assert_allclose(material.baseColorFactor[:3] / 255.0, linear(color), atol=0.5 / 255.0 + 1e-6)
        assert material.metallicFactor == 0.0


def test_glb_is_in_metres_with_y_up(built):
    """The scene reaches from the wall, x = -28, to the foot's end, x = 214; from y = 0 to 100, from z = -4 to 108."""
    loaded = trimesh.load(built / "loom.glb")
    np.testing.assert_allclose(loaded.bounds, [[-0.028, -0.004, -0.1], [0.214, 0.108, 0.0]], atol=1e-6)


def test_cables_in_glb_are_closed_and_as_large_as_they_are_long(built):
    loaded = trimesh.load(built / "loom.glb")
    for name, length in (("W1", 200.0), ("W2", 190.0), ("W3", 210.0)):
        transform, geometry = loaded.graph[name]
        mesh = loaded.geometry[geometry].copy()
        mesh.merge_vertices(merge_norm=True)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        mesh.apply_transform(transform)
        exact = math.pi * 4.0 * length * 1e-9
        assert 0.985 * exact < mesh.volume < exact


def test_a_part_that_occurs_six_times_is_stored_once(built):
    data = chunk((built / "loom.glb").read_bytes())
    names_of = {node["name"]: node for node in data["nodes"]}
    starts = [names_of[f"W{i} {end}"] for i in (1, 2, 3) for end in ("start", "end")]
    housings = [[data["nodes"][child]["mesh"] for child in node["children"]] for node in starts]
    assert len({tuple(meshes) for meshes in housings}) == 1
    assert len(data["meshes"]) == 1 + 2 + 3  # the bracket, housing and gasket, the cables


def test_glb_of_a_translucent_cable_far_away(cli, here):
    far = {"start": "{ position = [1e6, 0, 0] }", "end": "{ position = [1000300, 0, 0] }"}
    name = 'Käbel 电缆 "1"'
    path = write(here / "scene.toml", scene(cable(name, color=quoted("#2b6cb080"), **far)))
    assert cli("build", path, "-o", "out.glb").code == 0
    data = chunk((here / "out.glb").read_bytes())
    assert name in {node["name"] for node in data["nodes"]}
    (material,) = data["materials"]
    assert material["alphaMode"] == "BLEND"
    assert material["pbrMetallicRoughness"]["baseColorFactor"][3] == pytest.approx(128.0 / 255.0, abs=1e-6)
    # Its vertices are counted from its start, so that single precision keeps the circle round.
    transform, geometry = trimesh.load(here / "out.glb").graph[name]
    vertices = trimesh.load(here / "out.glb").geometry[geometry].vertices
    np.testing.assert_allclose(transform[:3, 3], [1000.0, 0.0, 0.0], rtol=1e-12, atol=1e-12)
    assert np.abs(np.linalg.norm(vertices[:20, 1:], axis=1).max() - 2.0) < 0.2
    assert np.abs(vertices).max() < 303.0


# --- STL and BREP ----------------------------------------------------------------------------------------------------


def test_stl_is_in_mm_and_its_bodies_are_closed(built):
    data = (built / "loom.stl").read_bytes()
    assert not data.startswith(b"solid")
    assert len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")
    loaded = trimesh.load(built / "loom.stl")
    np.testing.assert_allclose(loaded.bounds, [[-28.0, 0.0, -4.0], [214.0, 100.0, 108.0]], atol=1e-4)
    cables = sorted(body.volume for body in loaded.split() if len(body.faces) > 1500)[:3]
    np.testing.assert_allclose(cables, [math.pi * 4.0 * length for length in (190.0, 200.0, 210.0)], rtol=0.015)


def test_stl_says_when_rounding_eats_the_mesh(cli, here):
    far = {"start": "{ position = [1e6, 0, 0] }", "end": "{ position = [1000300, 0, 0] }"}
    path = write(here / "scene.toml", scene(cable(**far)))
    ended = cli("build", path, "-o", "out.stl")
    assert ended.code == 0
    assert "rounded by up to 0.06 mm, too much for the mesh's 0.02 mm" in ended.err
    # 0.06 mm of each coordinate and what the mesh takes itself may be more than 0.2 mm together.
    assert "too much for the mesh's 0.2 mm" in cli("build", path, "-o", "out.stl", "--mesh-tolerance", "0.2").err
    assert cli("build", path, "-o", "out.stl", "--mesh-tolerance", "0.3").err == ""


def test_brep_is_the_exact_compound(built):
    from OCP.BRep import BRep_Builder
    from OCP.BRepGProp import BRepGProp
    from OCP.BRepTools import BRepTools
    from OCP.GProp import GProp_GProps
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS_Shape

    from cablecad.brep.kernel import subshapes

    shape = TopoDS_Shape()
    assert BRepTools.Read_s(shape, str(built / "loom.brep"), BRep_Builder())
    solids = subshapes(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    assert len(solids) == 1 + 6 * 2 + 3
    volumes = []
    for solid in solids[-3:]:
        properties = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid, properties, 1e-6, True, False)
        volumes.append(properties.Mass())
    np.testing.assert_allclose(volumes, [math.pi * 4.0 * length for length in (200.0, 190.0, 210.0)], rtol=1e-4)


# --- all of them -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", FORMATS)
def test_same_bytes_in_another_process(process, built, kind):
    one = process("build", LOOM, "-o", f"again.{kind}", "-q")
    assert one.wait() == 0
    assert Path(f"again.{kind}").read_bytes() == (built / f"loom.{kind}").read_bytes()


def test_finer_when_asked(cli, here):
    path = write(here / "scene.toml", scene(cable()))
    sizes = []
    for tolerance in ("0.1", "0.001"):
        assert cli("build", path, "-o", "out.glb", "--mesh-tolerance", tolerance).code == 0
        mesh = trimesh.load(here / "out.glb", force="mesh")
        sizes.append((len(mesh.faces), mesh.volume * 1e9))
    exact = math.pi * 4.0 * 350.0
    assert sizes[1][0] > 20 * sizes[0][0]
    # A tube off by e loses 2 e / r of its volume at most.
    for (_, volume), tolerance in zip(sizes, (0.1, 0.001), strict=True):
        assert 0.0 < 1.0 - volume / exact < tolerance


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "out.obj"], "output out.obj: its name must end in .step, .stp, .glb, .stl or .brep"),
        (["-o", "out.step", "--mesh-tolerance", "0.1"], "a mesh tolerance is for .glb and .stl; out.step holds exact"),
        (["-o", "out.brep", "--mesh-tolerance", "0.1"], "a mesh tolerance is for .glb and .stl; out.brep holds exact"),
        (["-o", "out.glb", "--mesh-tolerance", "0"], "must be a positive number of mm; got 0.0"),
        (["-o", "out.glb", "--mesh-tolerance", "nan"], "must be a positive number of mm; got nan"),
        (["-o", "out.stl", "--mesh-tolerance", "1e-12"], "ask for a larger tolerance"),
    ],
)
def test_what_cannot_be_meant(cli, here, arguments, said):
    path = write(here / "scene.toml", scene(cable()))
    ended = cli("build", path, *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err
    assert names(here) == ["scene.toml"]


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize(
    ("text", "code"), [(cable(length="200"), 3), (cable(diameter="290"), 4), (part() + cable(), 5)]
)
def test_nothing_is_written_where_something_is_wrong(cli, here, kind, text, code):
    path = write(here / "scene.toml", scene(text, head=PVC))
    write(here / f"out.{kind}", b"old")
    assert cli("build", path, "-o", f"out.{kind}").code == code
    assert (here / f"out.{kind}").read_bytes() == b"old"
    assert names(here) == [f"out.{kind}", "scene.toml"]


@pytest.mark.parametrize("suffix", [".GLB", ".Stl", ".BREP"])
def test_suffix_in_capitals(cli, here, suffix):
    path = write(here / "scene.toml", scene(cable()))
    assert cli("build", path, "-o", f"out{suffix}").out == f"out{suffix}\n"
