"""What is loaded when: each figure taken in a process of its own."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import cablecad

HEAVY = ["OCP", "numpy", "scipy", "pydantic", "pydantic_core", "rich"]


def loaded_after(code: str, tmp_path) -> set[str]:
    """Which of the heavy packages a piece of code loads."""
    report = f"import sys, json; {code}; print(json.dumps([n for n in {HEAVY!r} if n in sys.modules]))"
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, check=True, cwd=tmp_path)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_import_cablecad_loads_nothing_heavy(tmp_path) -> None:
    assert loaded_after("import cablecad", tmp_path) == set()


def test_what_types_are_checked_by_is_what_is_loaded() -> None:
    """The stub beside `__init__` has all public names, each from the module that it is loaded from."""
    stub = (Path(cablecad.__path__[0]) / "__init__.pyi").read_text(encoding="utf-8")
    named = re.findall(r"^from (\S+) import (\w+) as (\w+)$", stub, re.MULTILINE)
    assert all(name == public for _, name, public in named)
    assert {public: module for module, _, public in named} == cablecad._HOME


def test_cable_objects_need_nothing_heavy(tmp_path) -> None:
    code = "import cablecad as cc; cc.Cable('a', 1.0, cc.Pin((0, 0, 0)), cc.Pin((1, 0, 0)), length=2.0)"
    assert loaded_after(code, tmp_path) == set()


def test_python_solve_needs_numpy_only(tmp_path) -> None:
    code = (
        "import cablecad as cc; cc.solve(cc.Cable('a', 1.0, cc.Pin((0, 0, 0)), cc.Pin((1, 0, 0)), length=2.0)).self_gap"
    )
    assert loaded_after(code, tmp_path) == {"numpy"}


@pytest.mark.parametrize(
    ("arguments", "heavy"),
    [
        (["--help"], set()),
        (["build", "--help"], set()),
        (["bench", "--help"], set()),
        (["schema"], {"pydantic_core"}),  # its models would take as long to load as a cable to solve
        (["new", "scene.toml"], {"pydantic_core"}),
        (["solve", "scene.toml", "--json"], {"pydantic_core", "numpy"}),
    ],
)
def test_commands_load_what_they_need(arguments: list[str], heavy: set[str], tmp_path) -> None:
    from cablecad.scene import starter_scene

    if arguments[0] != "new":
        (tmp_path / "scene.toml").write_text(starter_scene())
    code = (
        f"import cablecad.cli\ntry:\n    cablecad.cli.main({arguments!r})\nexcept SystemExit as end:\n"
        "    assert not end.code, end.code\n"
    )
    report = f"{code}import sys, json\nprint(json.dumps([n for n in {HEAVY!r} if n in sys.modules]))"
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert set(json.loads(done.stdout.splitlines()[-1])) <= heavy


def test_a_solved_cable_loads_nothing_it_does_not_need(tmp_path) -> None:
    """What would add a few milliseconds each, and crept in before; numpy 1 loads some of it by itself."""
    from cablecad.scene import starter_scene

    (tmp_path / "scene.toml").write_text(starter_scene())
    needless = [
        *("numpy.ma", "numpy.random", "numpy.fft", "importlib.metadata", "difflib", "shutil", "tempfile"),
        *("cablecad.brep", "cablecad.files", "cablecad.scene.override", "cablecad.scene.draft"),
    ]
    code = (
        "import sys, numpy\nbefore = set(sys.modules)\nimport cablecad.cli\n"
        "try:\n    cablecad.cli.main(['solve', 'scene.toml'])\nexcept SystemExit:\n    pass\n"
    )
    report = f"{code}import json\nprint(json.dumps([n for n in {needless!r} if n in sys.modules and n not in before]))"
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert json.loads(done.stdout.splitlines()[-1]) == []


def test_public_names_exist() -> None:
    import cablecad

    for name in cablecad.__all__:
        assert getattr(cablecad, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        cablecad.nonsense  # noqa: B018 - the access is the test
