"""Ends on parts become numbers: named ports from the scene itself, others from the part's geometry."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from cablecad.errors import CablecadError, ExchangeError, Mistake, SceneError
from cablecad.model import Cable, Part, PartPort, Port, Scene, find_port, placed_port

if TYPE_CHECKING:
    from cablecad.brep.document import Document
    from cablecad.brep.features import Feature
    from cablecad.rod.solution import RodSolution


def parts_to_read(scene: Scene) -> list[Part]:
    """The parts whose geometry is needed to know where cables end, in the order of the scene."""
    asked = {end.part for cable in scene.cables for end in _ends(cable).values() if end.near is not None}
    return [part for part in scene.parts if part.name in asked]


def _ends(cable: Cable) -> dict[str, PartPort]:
    return {key: end for key in ("start", "end") if isinstance(end := getattr(cable, key), PartPort)}


@dataclass
class Resolved:
    """A scene whose ends are numbers.

    Attributes:
        scene: The scene; a cable in `errors` is as it was.
        remarks: By the name of a cable: of each end taken from geometry, what it was found to be.
        errors: By the name of a cable, why its ends are not known.
    """

    scene: Scene
    remarks: dict[str, list[str]] = field(default_factory=dict)
    errors: dict[str, CablecadError] = field(default_factory=dict)

    @property
    def known(self) -> list[Cable]:
        """The cables whose ends are numbers."""
        return [cable for cable in self.scene.cables if cable.name not in self.errors]

    def answers(self, solved: Iterable[RodSolution | CablecadError]) -> list[RodSolution | CablecadError]:
        """One answer for each cable of the scene: its own error, or the next of those for `known`."""
        each = iter(solved)
        return [self.errors[cable.name] if cable.name in self.errors else next(each) for cable in self.scene.cables]


def resolve_ports(scene: Scene, documents: Mapping[str, Document]) -> Resolved:
    """Put numbers in place of every end on a part.

    Args:
        scene: Any scene.
        documents: What was read of the parts of `parts_to_read`, by name; one that could not be read is not there.

    Raises:
        SceneError: A point that does not tell which feature is meant, or data that do not go with the ends that were
            found; all of them at once.
    """
    resolved = Resolved(scene)
    if not any(_ends(cable) for cable in scene.cables):
        return resolved
    features: dict[int, list[Feature]] = {}
    parts = {part.name: part for part in scene.parts}
    cables: list[Cable] = []
    mistakes: list[Mistake] = []
    for cable in scene.cables:
        found: dict[str, Port] = {}
        for key, end in _ends(cable).items():
            part = parts[end.part]
            try:
                if end.near is None:
                    found[key] = placed_port(part, find_port(part, end.port or ""), end.straight)
                elif part.name in documents:
                    found[key], remark = _nearest(part, documents[part.name], end, features)
                    resolved.remarks.setdefault(cable.name, []).append(
                        f"{key} is taken from part {part.name}: {remark}"
                    )
                else:
                    unread = f"its {key} is on part {part.name}, which could not be read"
                    resolved.errors[cable.name] = ExchangeError(unread)
            except SceneError as error:
                mistakes += [mistake.under(f"cables.{cable.name}.{key}") for mistake in error.mistakes]
            except CablecadError as error:
                resolved.errors[cable.name] = error
        if len(found) == len(_ends(cable)):
            try:
                cables.append(replace(cable, start=found.get("start", cable.start), end=found.get("end", cable.end)))
            except SceneError as error:
                mistakes += [mistake.under(f"cables.{cable.name}") for mistake in error.mistakes]
        else:
            cables.append(cable)
    if mistakes:
        raise SceneError(mistakes, source=str(scene.source or ""))
    resolved.scene = replace(scene, cables=tuple(cables))
    return resolved


def _nearest(part: Part, document: Document, end: PartPort, features: dict[int, list[Feature]]) -> tuple[Port, str]:
    """The port of the part's feature nearest to a point, in the scene, and what it was found to be.

    `features` keeps those of each document, which may stand for several parts and ends.
    """
    from cablecad.brep.features import find_features
    from cablecad.brep.ports import nearest_port

    assert end.near is not None
    if id(document) not in features:
        features[id(document)] = find_features(document.shape)
    found = nearest_port(document.shape, end.near, features[id(document)])
    outward = part.rotation.turned(found.outward)
    return Port(part.placed(found.position), outward, end.straight), f"{found} (in its own coordinates)"
