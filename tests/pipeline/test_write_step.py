"""`write_step` writes what can be written, and never leaves out what cannot."""

from __future__ import annotations

from pathlib import Path

import pytest

import cablecad as cc
from cablecad.brep.step import read_tree

CABLE = cc.Cable("W", 4.0, cc.Port((0, 0, 0), (0, 0, 1)), cc.Port((0, 120, 0), (0, 0, 1)), length=350.0)
PART = Path(__file__).parents[2] / "samples" / "parts" / "connector.step"


def test_cables_and_parts_in_any_order(tmp_path: Path) -> None:
    cc.write_step([cc.Part("box", PART), cc.build(CABLE)], tmp_path / "a.step")
    (root,) = read_tree(tmp_path / "a.step")
    assert {group.name: [node.occurrence for node in group.children] for group in root.children} == {
        "parts": ["box"],
        "cables": ["W"],
    }


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("item", [CABLE, cc.solve(CABLE), "box.step", None])
def test_what_cannot_be_written_is_refused(item: object, place: int, tmp_path: Path) -> None:
    items: list[object] = [cc.build(CABLE)]
    items.insert(place, item)
    with pytest.raises(cc.UsageError, match=rf"items\[{place}\] is a {type(item).__name__}, which cannot be written"):
        cc.write_step(items, tmp_path / "a.step")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
