"""Rows made from the scene that was resolved before: the same scenes, and the same mistakes, as resolved whole."""

from __future__ import annotations

import random
from functools import partial

import pytest

from cablecad.errors import SceneError
from cablecad.scene import RawScene, clean_value, find_target, load_raw_scene, overlaps
from cablecad.scene.resolve import resolve_scene
from cablecad.scene.vary import vary_scene

SCENE = """\
format = 1
[tolerance]
shape = 0.002
[materials.pvc]
youngs_modulus = 3890.0
[materials.pur]
bending_stiffness = 900.0
[[parts]]
name = "plate"
step = "plate.step"
[[parts.ports]]
name = "J1"
position = [12, 0, 3]
outward = [0, 0, 1]
[[parts.ports]]
name = "J2"
position = [50, 0, 3]
[[cables]]
name = "W1"
diameter = 4
length = 350
material = "pvc"
start = { position = [0, 0, 0], outward = [0, 0, 1], straight = 10 }
end = { position = [0, 120, 0], direction = [0, 0, -1] }
[[cables]]
name = "W2"
diameter = 4.0
chord = 100.0
rise = 20.0
start = { position = [0, 0, 0] }
end = { toward = [0, 0, 1] }
[[cables]]
name = "W3"
diameter = 4.0
length = "shortest"
min_bend_radius = 20.0
start = { part = "plate", port = "J1" }
end = { position = [0, 120, 0], outward = [0, 0, 1] }
[[cables]]
name = "W4"
diameter = 4.0
force = 3.0
material = "pur"
start = { part = "plate", port = "J2" }
end = { position = [0, 120, 0] }
"""

PLACES = [
    *(
        f"cables.W{i}.{key}"
        for i in (1, 2, 3, 4)
        for key in (
            *("name", "diameter", "length", "slack", "chord", "force", "angle_deg", "rise", "bend_radius", "material"),
            *("color", "min_bend_radius", "bulge", "equilibrium", "equilibrium.winding", "allow_contact"),
            *("start.position", "start.outward", "start.direction", "start.straight", "start.part", "start.port"),
            *("end.position", "end.outward", "end.direction", "end.straight", "end.toward", "end.near", "start"),
        )
    ),
    *("cables.W1.start.position[0]", "cables.W1.start.outward[2]", "cables.W1.end.direction[1]"),
    *("name", "tolerance.shape", "materials.pvc.youngs_modulus", "parts.plate.position", "parts.plate.step"),
]

VALUES = [
    *(300, 300.0, 0.1, 1, 0, -1, -5.5, 1e-9, 1e200, 10**300, 10**400, float("nan"), float("inf"), True, False, None),
    *("shortest", "pvc", "pur", "plate", "J1", "W2", "#112233", "", "007", [0, 0, 1], [1.5, 2, 3], [0, 0, 0], [1, 2]),
    *([1, 2, "3"], [1, 2, True], [1e200, 0, 0], [float("nan"), 0, 0], {"winding": 1}, {}, []),
    *({"position": [1, 2, 3], "outward": [0, 1, 0]}, {"position": [1, 2, 3], "slope": 1}),
]


@pytest.fixture
def raw(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return load_raw_scene(path)


def outcome(resolve):
    """A scene in every digit and type, or its mistakes as they are told."""
    try:
        return repr(resolve())
    except SceneError as error:
        return [str(mistake) for mistake in error.mistakes], str(error)


def changes_of(rng, raw, made=()):
    """Some places and values that do not overlap; half of the rows change numbers alone, as most tables do."""
    changes = []
    for _ in range(rng.choice([1, 1, 2, 3])):
        try:
            target = find_target(rng.choice(PLACES), raw.data)
        except SceneError:
            continue
        if any(overlaps(target, other) for other, _ in (*made, *changes)):
            continue
        if rng.random() < 0.5:
            number = partial(rng.choice, [rng.uniform(100.0, 400.0), rng.randint(1, 300), 0, -1.0])
            one = isinstance(target.place[-1], int) or target.place[-1] not in ("position", "outward", "direction")
            value = number() if one else [number() for _ in range(3)]
        else:
            value = rng.choice(VALUES)
        changes.append((target, value))
    return changes


def test_rows_are_those_of_a_full_resolve(raw):
    rng = random.Random(7)
    good, bad, plain = 0, 0, 0
    for _ in range(3000):
        changes = changes_of(rng, raw)
        row = raw.overridden(changes)
        whole = outcome(lambda row=row: resolve_scene(row.data, source=row.source))
        assert outcome(row.resolve) == whole, changes
        good += isinstance(whole, str)
        bad += not isinstance(whole, str)
        plain += vary_scene(raw.resolve(), changes) is not None
    assert good > 250
    assert bad > 1000
    assert plain > 100


def test_a_variant_of_a_variant_is_one_of_the_scene(raw):
    rng = random.Random(8)
    for _ in range(200):
        first = changes_of(rng, raw)
        second = changes_of(rng, raw, first)
        row = raw.overridden(first).overridden(second)
        assert outcome(row.resolve) == outcome(lambda row=row: resolve_scene(row.data, source=row.source))


def test_values_of_python_come_as_they_are_cleaned(raw):
    target = find_target("cables.W1.length", raw.data)
    for value in (10**400, 2**1023, 310):
        cleaned, _ = clean_value(value)
        for one in (value, cleaned):
            row = raw.overridden([(target, one)])
            assert outcome(row.resolve) == outcome(lambda row=row: resolve_scene(row.data, source=row.source))


def test_a_base_with_mistakes_serves_its_rows(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.replace("length = 350\n", ""))
    raw = load_raw_scene(path)
    row = raw.overridden([(find_target("cables.W1.length", raw.data), 300.0)])
    assert row.resolve().cables[0].length == 300.0
    assert isinstance(row, RawScene)
    with pytest.raises(SceneError):
        raw.resolve()
