"""A scene as its file has it, before anything is made of it: what overrides act on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cablecad.errors import Mistake
from cablecad.model import Scene
from cablecad.scene.resolve import resolve_scene, type_mistakes

if TYPE_CHECKING:
    from cablecad.scene.override import Target


@dataclass(frozen=True, slots=True)
class RawScene:
    """The raw data of a scene; from `load_raw_scene`.

    Attributes:
        data: The top table; not to be changed in place, for variants share what they do not override.
        source: The file; the paths of parts begin in its folder.
    """

    data: dict[str, Any]
    source: Path | None = None

    def overridden(self, changes: Iterable[tuple[Target, Any]]) -> RawScene:
        """The scene with values in other places; a value of None takes its key out."""
        data = self.data
        for target, value in changes:
            data = target.put(data, value)
        return RawScene(data, self.source)

    def type_mistakes(self) -> list[Mistake]:
        """Unknown keys and values of a wrong type."""
        return type_mistakes(self.data)

    def resolve(self) -> Scene:
        """Make the scene.

        Raises:
            SceneError: All mistakes at once.
        """
        return resolve_scene(self.data, source=self.source)
