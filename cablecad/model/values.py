"""Checks of single values, each yielding what is wrong with it, and the range of every number that has one."""

from __future__ import annotations

import math
import re
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from numbers import Integral, Real
from typing import NamedTuple, Self

from cablecad.errors import Mistake, SceneError

Vector = tuple[float, float, float]

COLOR = re.compile(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{8})")
"""What a colour looks like."""


class Range(NamedTuple):
    """The finite numbers a value may be; None leaves a side open."""

    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None


ANY_NUMBER = Range()
POSITIVE = Range(above=0.0)

SMALLEST, LARGEST = 1e-100, 1e100
"""Sizes beyond these, or their squares' inverses, are no doubles; no cable is near them."""

COORDINATE = Range(above=-LARGEST, below=LARGEST)


RANGES = {
    **dict.fromkeys(("diameter", "length", "slack", "force", "rise", "bend_radius", "min_bend_radius"), POSITIVE),
    "angle_deg": Range(above=0.0, below=180.0),  # of a cable's ends: a rotation's angle may be any
    "straight": Range(least=0.0),
    **dict.fromkeys(("youngs_modulus", "bending_stiffness", "torsional_stiffness", "mass_per_length"), POSITIVE),
    "poissons_ratio": Range(above=-1.0, most=0.5),  # what elasticity allows an isotropic material
}
"""The range of every number that has one, by its key: for the checks here and for the schema of scene files."""


def number_mistakes(path: str, value: object, allowed: Range = ANY_NUMBER, *, sized: bool = False) -> Iterator[Mistake]:
    """Check that `value` is a finite number in its range; a `sized` one is computed with, so that its square is one."""
    above, least, below, most = allowed
    if isinstance(value, bool) or not isinstance(value, Real):
        yield Mistake(path, "must be a number", value)
        return
    try:
        number = float(value)
    except OverflowError:  # a whole number beyond the largest double
        number = math.inf
    if not math.isfinite(number):
        yield Mistake(path, "must be a finite number", value)
    elif sized and number and not SMALLEST < abs(number) < LARGEST:
        yield Mistake(path, f"must be 0 or between {SMALLEST:g} and {LARGEST:g}, which can be computed with", value)
    elif above is not None and number <= above:
        yield Mistake(path, f"must be greater than {above:g}", value)
    elif least is not None and number < least:
        yield Mistake(path, f"must be {least:g} or more", value)
    elif below is not None and number >= below:
        yield Mistake(path, f"must be less than {below:g}", value)
    elif most is not None and number > most:
        yield Mistake(path, f"must be {most:g} or less", value)


def vector_mistakes(path: str, value: object, *, axis: bool = False) -> Iterator[Mistake]:
    """Check that `value` is three finite numbers, and not all zero where it is an axis."""
    if not isinstance(value, Sequence) or isinstance(value, str | bytes) or len(value) != 3:
        yield Mistake(path, "must be three numbers [x, y, z]", value)
        return
    mistakes = [m for i, part in enumerate(value) for m in number_mistakes(f"{path}[{i}]", part, COORDINATE)]
    yield from mistakes
    if axis and not mistakes and math.hypot(*value) == 0.0:
        yield Mistake(path, "an axis must not be zero; write a direction such as [0, 0, 1]", value)


def text_mistakes(path: str, value: object) -> Iterator[Mistake]:
    """Check that `value` is a name: text with something in it, on one line."""
    if not isinstance(value, str) or not value.strip():
        yield Mistake(path, "must be a text that is not empty", value)
    elif value != value.strip():
        yield Mistake(path, "must not begin or end with a blank, which STEP files do not keep", value)
    elif any(unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") for c in value):
        yield Mistake(path, "must not contain control characters such as line breaks or tabs", value)


def as_vector(value: object) -> object:
    """The numbers of any sequence (a numpy array too) as a tuple of floats; anything else unchanged."""
    if not isinstance(value, Iterable) or isinstance(value, str | bytes | Set | Mapping):  # sets have no order
        return value
    try:
        parts = tuple(value)
    except TypeError:  # an array without an axis
        return value
    if any(isinstance(part, str | bytes | bool) for part in parts):  # float() would read "4" and True
        return value
    try:
        return tuple(float(part) for part in parts)
    except (TypeError, ValueError, OverflowError):
        return value


def unit(vector: Vector) -> Vector:
    """`vector` scaled to length one, safe for components near the limits of a double."""
    x, y, z = vector
    largest = max(abs(x), abs(y), abs(z))
    x, y, z = x / largest, y / largest, z / largest
    norm = math.hypot(x, y, z)
    return x / norm, y / norm, z / norm


_set = object.__setattr__
"""Of a frozen object, by whoever makes it."""


class Checked(ABC):
    """Base of the dataclasses that refuse to be made with mistakes in them."""

    __slots__ = ()

    def __post_init__(self) -> None:
        keys: tuple[str, ...] = self.__slots__
        for key in keys:
            value: object = getattr(self, key)
            if type(value).__module__ == "numpy" and isinstance(value, Real):
                self._set(**{key: int(value) if isinstance(value, Integral) else float(value)})
        mistakes = list(self._mistakes())
        if mistakes:
            raise SceneError(mistakes)

    @abstractmethod
    def _mistakes(self) -> Iterator[Mistake]:
        """What is wrong with the values."""

    @classmethod
    def _trusted(cls, **values: object) -> Self:
        """An object of values that were checked before, all of them given."""
        made = object.__new__(cls)
        for key, value in values.items():
            _set(made, key, value)
        return made

    def _set(self, **values: object) -> None:
        for key, value in values.items():
            _set(self, key, value)
