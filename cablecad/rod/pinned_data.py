"""The paper's cable: pinned at both ends, in a plane, given by any two independent data, or by more that agree."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from cablecad.errors import InfeasibleError, Mistake, SceneError
from cablecad.rod.arch import Arch
from cablecad.rod.pair import EPS, arches, as_length, out_of_reach, shown

AGREEMENT = 1e-6
"""Data beyond the two that are needed must agree with them to this part: looser than any figure a person copies with
seven digits, far tighter than any that means another shape."""

_MET = 1e-9
"""To this part an arch meets the two data it was solved for: their rounding may cost digits, but no more than these."""

_ORDER = ("slack", "chord", "length", "angle_deg", "rise", "bend_radius", "force")
"""Which data are believed first when more than two are given: what the user measured on the parts, then the length."""

_SCALES = ("length", "rise", "bend_radius", "force", "chord")
"""Which datum sets the scale: the chord last, for it may vanish."""


@dataclass(frozen=True)
class Pinned:
    """An arch with its scale.

    Attributes:
        arch: The shape.
        omega: sqrt(F / EI) [1/mm].
        length: [mm]; as it was given, where it was.
        chord: [mm], negative once the ends have crossed; as it was given, where it was.
        other: The arch with the greater end angle that meets the same two data, and its scale; or None.
        notes: What the report should say of redundant data.
    """

    arch: Arch
    omega: float
    length: float
    chord: float
    other: Pinned | None = None
    notes: tuple[str, ...] = ()

    def datum(self, name: str, EI: float | None = None) -> float:
        """Any datum of this cable, in the units of the scene file."""
        match name:
            case "length":
                return self.length
            case "chord":
                return self.chord
            case "angle_deg":
                return math.degrees(self.arch.angle)
            case "slack":
                excess = self.arch.excess_ratio
                # Of nearly straight cables the one keeps its digits, of those whose ends nearly meet the other.
                return excess / (1.0 - excess) if excess < 0.5 else (self.length - self.chord) / self.chord
            case "force":
                return math.nan if EI is None else EI * self.omega**2
            case _:
                return self.arch.size(name) / self.omega


def solve_pinned(
    data: Mapping[str, float],
    *,
    EI: float | None = None,
    names: Mapping[str, str] | None = None,
    blur: float = 0.0,
) -> Pinned:
    """Find the first mode of a rod pinned at both ends from two or more of its data.

    Args:
        data: Two or more of length, chord (signed), rise, bend_radius [mm], force [N, compressive], angle_deg
            [degrees, above 0 and below 180] and slack; not only slack and angle_deg, which fix no size.
        EI: Bending stiffness [N mm^2]; a force needs it.
        names: What to call a datum in a message, where that is not its key (``{"chord": "end.position"}``).
        blur: By how much the chord may be off, beyond the rounding of its own digits: of ends far from the origin [mm].

    Returns:
        The arch and its scale. Of two answers the one with the smaller end angle; the other is its `other`.

    Raises:
        InfeasibleError: No pinned cable has these data; the message says what bounds them.
        SceneError: A third datum contradicts the first two; the message gives the consistent value.

    Accuracy: every datum of the result to 1e-13 of itself, chords to 1e-13 of the length
        (tests/rod/test_arch.py), where the data determine it: a force within 1e-12 of the Euler load, or a rise at
        its maximum, leave the angle to the square root of their rounding.
    """
    given = [key for key in _ORDER if key in data]
    first = given[0]
    scaled = [key for key in given[1:] if not {first, key} <= {"slack", "angle_deg"}]
    if len(given) < 2 or not scaled:
        raise ValueError(f"a pinned cable needs two data that fix its size; got {', '.join(given) or 'none'}")
    second = scaled[0]
    primary = {first: data[first], second: data[second]}
    if primary.keys() == {"slack", "chord"} and primary["slack"] > 1.0:
        # The chord of a cable much longer than it says nothing of its size.
        primary = {"length": primary["chord"] * (1.0 + primary["slack"]), "chord": primary["chord"]}
    rest = {key: data[key] for key in given if key not in (first, second)}
    primary, rest = _better_known(primary, rest, EI, blur)
    candidates = [_scale(arch, primary, EI) for arch in arches(primary, EI)]
    if not all(_meets(candidate, primary, EI) for candidate in candidates):
        raise InfeasibleError(out_of_reach(primary, EI))
    called = dict(names or {})
    verdicts = [_disagreements(candidate, rest, primary, EI, called) for candidate in candidates]
    chosen = next((i for i, (mistakes, _) in enumerate(verdicts) if not mistakes), 0)
    mistakes, notes = verdicts[chosen]
    if mistakes:
        raise SceneError(mistakes)
    answer = candidates[chosen]
    other = candidates[1] if chosen == 0 and len(candidates) > 1 and not rest else None
    return Pinned(answer.arch, answer.omega, answer.length, answer.chord, other, notes)


def _meets(answer: Pinned, primary: Mapping[str, float], EI: float | None) -> bool:
    """Whether a cable has the two data it was solved for."""
    sizes = {key: answer.length if key == "chord" else value for key, value in primary.items()}
    return all(abs(answer.datum(key, EI) - primary[key]) <= _MET * size for key, size in sizes.items())


def _better_known(
    primary: dict[str, float], rest: dict[str, float], EI: float | None, blur: float
) -> tuple[dict[str, float], dict[str, float]]:
    """Of a nearly straight cable take a datum that has digits of its bend for the chord, whose digits are the length's.

    Only where it says what the chord does, but for the rounding of that.
    """
    better = next((key for key in ("angle_deg", "rise", "bend_radius") if key in rest), None)
    if better is None or primary.keys() != {"length", "chord"} or not 0.0 < primary["chord"] < primary["length"]:
        return primary, rest
    # What rounding leaves open of the excess, and twice what it does of the bend.
    open_share = (EPS * primary["length"] + blur) / (primary["length"] - primary["chord"])
    if open_share < AGREEMENT:
        return primary, rest
    (arch,) = arches(primary, EI)
    if abs(math.log(_scale(arch, primary, EI).datum(better, EI) / rest[better])) > open_share:
        return primary, rest
    others = {key: value for key, value in rest.items() if key != better}
    return {"length": primary["length"], better: rest[better]}, {"chord": primary["chord"]} | others


def _disagreements(
    answer: Pinned,
    rest: Mapping[str, float],
    primary: Mapping[str, float],
    EI: float | None,
    called: Mapping[str, str],
) -> tuple[list[Mistake], tuple[str, ...]]:
    """What in `rest` contradicts `answer`, and notes on what agrees but not to rounding."""
    mistakes, notes = [], []
    one, other = primary.values()
    basis = " and ".join(
        f"{called.get(key, key)} = {shown(key, value, beside=other if value == one else one)}"
        for key, value in primary.items()
    )
    for key, value in rest.items():
        consistent = answer.datum(key, EI)
        scale = answer.length if key == "chord" else max(abs(value), abs(consistent))
        off = abs(value - consistent) / scale
        name = called.get(key, key)
        if off > AGREEMENT:
            told = shown(key, consistent, beside=value)
            problem = f"contradicts {basis}, which give {told}; write that, or leave one of them out"
            mistakes.append(Mistake(name, problem, value))
        elif off > 1e-12:
            given, taken = shown(key, value, beside=consistent), shown(key, consistent, beside=value)
            notes.append(f"{name} = {given} was taken as {taken}, which {basis} give")
    return mistakes, tuple(notes)


def _scale(arch: Arch, primary: Mapping[str, float], EI: float | None) -> Pinned:
    """Give an arch the size its data ask for, keeping a given length and chord as they were given."""
    key = next(key for key in _SCALES if key in primary)
    value = as_length(key, primary[key], EI)
    if arch.size(key) * value <= 0.0:
        raise InfeasibleError(
            f"an end angle of {math.degrees(arch.angle):.9g} degrees with a chord of {value:.9g} mm is impossible: "
            "above 130.7099 degrees the ends have crossed and the chord is negative, below it is positive; "
            "give the end as `toward` with the length instead of a position"
        )
    omega = arch.size(key) / value
    length = primary.get("length", arch.size("length") / omega)
    if "slack" in primary and "chord" in primary:
        length = primary["chord"] * (1.0 + primary["slack"])
    chord = primary.get("chord", length * (arch.size("chord") / arch.size("length")))
    return Pinned(arch, omega, length, chord)
