"""The error family: one base, one class for each kind of failure, each with its standard base.

A message says what failed, where, with which numbers, and what to do. `SceneError` carries every mistake of a
scene at once. `EXIT_CODES` ties the family to the exit codes the command line promises.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial


class CablecadError(Exception):
    """Base of every error cablecad raises on purpose."""

    exit_code = 1


@dataclass(frozen=True, slots=True)
class Mistake:
    """One mistake in a scene: where it is, what stands there, what is wrong and how to mend it.

    Attributes:
        path: Dotted place, such as ``cables.W1.end.position[1]``; empty for the scene as a whole.
        problem: What is wrong and what to write instead.
        value: The offending value as the user wrote it; ``...`` where there is none (a missing key).
    """

    path: str
    problem: str
    value: object = ...

    def __str__(self) -> str:
        where = self.path or "scene"
        if self.value is ...:
            return f"{where}: {self.problem}"
        shown = repr(self.value)
        if len(shown) > 80:
            shown = f"{shown[:77]}..."
        return f"{where} = {shown}: {self.problem}"

    def __reduce__(self) -> tuple[object, ...]:
        # Objects of a host, such as CadQuery's vectors, need not be able to go to another process.
        return Mistake, (self.path, self.problem, self.value if _is_plain(self.value) else _Shown(repr(self.value)))

    def under(self, prefix: str) -> Mistake:
        """The same mistake seen from an enclosing object called `prefix`."""
        if not prefix or not self.path:
            return replace(self, path=prefix or self.path)
        joint = "" if self.path.startswith("[") else "."
        return replace(self, path=f"{prefix}{joint}{self.path}")


@dataclass(frozen=True, slots=True)
class _Shown:
    """What stands for a value of which only the text is left."""

    text: str

    def __repr__(self) -> str:
        return self.text


def _is_plain(value: object) -> bool:
    """Whether a value is of Python's own kinds, through and through."""
    if isinstance(value, list | tuple):
        return all(_is_plain(part) for part in value)
    if isinstance(value, dict):
        return all(_is_plain(part) for pair in value.items() for part in pair)
    return value is None or value is ... or isinstance(value, str | bytes | bool | int | float)


class SceneError(CablecadError, ValueError):
    """A scene, or an object of one, is not valid; lists every mistake found."""

    exit_code = 2

    def __init__(self, mistakes: Iterable[Mistake], *, source: str = "") -> None:
        self.mistakes = tuple(mistakes)
        self.source = source
        super().__init__(self._text())

    def __reduce__(self) -> tuple[object, ...]:
        # An exception is pickled as its class and its text, by itself; worker processes send their errors so.
        return partial(type(self), source=self.source), (self.mistakes,), self.__dict__

    def _text(self) -> str:
        lines = [str(mistake) for mistake in self.mistakes]
        if not self.source and len(lines) == 1:
            return lines[0]
        count = "1 mistake" if len(lines) == 1 else f"{len(lines)} mistakes"
        return "\n  ".join([f"{self.source or 'scene'}: {count}", *lines])


class UsageError(CablecadError, ValueError):
    """A call asks for something that makes no sense, such as writing an output over an input."""

    exit_code = 2


class InfeasibleError(CablecadError, ValueError):
    """Physics or geometry forbids the shape that was asked for."""

    exit_code = 3


class NotPlanarError(InfeasibleError):
    """The ends do not lie in one plane, and the planar model was the only one to take."""


class SolveError(CablecadError, RuntimeError):
    """No solution was found although none is known to be impossible."""

    exit_code = 3


class GeometryError(CablecadError, ValueError):
    """A solid could not be made, or failed its check."""

    exit_code = 4


class InvalidTubeError(GeometryError):
    """The tube would cut into itself."""


class RuleError(GeometryError):
    """A rule of the user's, such as the least bend radius, is broken."""


class ExchangeError(CablecadError, OSError):
    """A file could not be read or written."""

    exit_code = 5


class MissingDependencyError(CablecadError, ImportError):
    """An optional package is needed and not installed."""

    exit_code = 5


class WorkerStartError(CablecadError, RuntimeError):
    """No worker process can be started."""

    exit_code = 5


class WorkerDiedError(CablecadError, RuntimeError):
    """The process that worked on a task died; a batch tells of it as the row's end."""


class OvertimeError(CablecadError, TimeoutError):
    """A task took longer than it may, and its process was ended; a batch tells of it as the row's end."""
