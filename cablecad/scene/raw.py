"""A scene as its file has it, before anything is made of it: what overrides act on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cablecad.errors import Mistake, SceneError
from cablecad.model import Scene
from cablecad.scene.resolve import resolve_scene, type_mistakes

if TYPE_CHECKING:
    from cablecad.scene.override import Target

    Changes = tuple[tuple[Target, Any], ...]


@dataclass(frozen=True)
class RawScene:
    """The raw data of a scene; from `load_raw_scene`.

    Attributes:
        data: The top table; not to be changed in place, for variants share what they do not override.
        source: The file; the paths of parts begin in its folder.
        base: The scene this one is a variant of.
        changes: What was overridden in it.
    """

    data: dict[str, Any]
    source: Path | None = None
    base: RawScene | None = field(default=None, compare=False, repr=False)
    changes: Changes = field(default=(), compare=False, repr=False)

    def overridden(self, changes: Iterable[tuple[Target, Any]]) -> RawScene:
        """The scene with values in other places; a value of None takes its key out."""
        data, changes = self.data, tuple(changes)
        for target, value in changes:
            data = target.put(data, value)
        return RawScene(data, self.source, self if self.base is None else self.base, self.changes + changes)

    def type_mistakes(self) -> list[Mistake]:
        """Unknown keys and values of a wrong type."""
        return type_mistakes(self.data)

    def resolve(self) -> Scene:
        """Make the scene.

        Raises:
            SceneError: All mistakes at once.
        """
        known = None if self.base is None else self.base._good
        if known is not None:
            from cablecad.scene.vary import vary_scene

            varied = vary_scene(known, self.changes)
            if varied is not None:
                return varied
        return resolve_scene(self.data, source=self.source)

    @cached_property
    def _good(self) -> Scene | None:
        """The scene, kept for its variants; None where there are mistakes in it."""
        try:
            return resolve_scene(self.data, source=self.source)
        except SceneError:
            return None
