"""The paper's cable: pinned at both ends, in a plane, given by any two independent data.

With k = sin(beta_0 / 2) and omega = sqrt(F / EI) everything about its first mode is known in closed form:

    length = 2 K / omega        chord = 2 (2 E - K) / omega       rise = 2 k / omega
    bend_radius = 1 / (2 k omega)       force = EI omega^2        angle = 2 asin(k)

so that a datum is either a length times a function of k alone, or a function of k alone (the angle, the slack). Two
data give one equation for k and then the scale. It is solved in t = ln(m / m1), in which m and m1 both keep their
relative precision, from an end angle of 1e-6 degrees to a chord of -0.99 lengths, where m1 = 3e-173.

Source: the paper's equations (8)-(20), which were checked in high precision; beta_0 may be anything up to 180 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from cablecad.errors import InfeasibleError, Mistake, SceneError
from cablecad.rod.elliptic import complete_2e_minus_k, complete_d, complete_e, complete_k

AGREEMENT = 1e-6
"""Data beyond the two that are needed must agree with them to this part: looser than any figure a person copies with
seven digits, far tighter than any that means another shape."""

_EPS = 2.220446049250313e-16
_ROUNDING = 8 * _EPS
"""Room for the rounding of given data at the edge of what is possible."""

_STEEPEST = 690.0
"""Largest |t|: m or m1 = 1e-300, at the edge of the doubles; a chord of -0.994 lengths, an angle of 1e-148 degrees."""

_UNITS = {"angle_deg": "degrees", "force": "N", "slack": ""}


@dataclass(frozen=True)
class Arch:
    """The first mode of a rod pinned at both ends, up to its scale.

    Attributes:
        m: k^2.
        m1: 1 - m, to its own relative precision.
    """

    m: float
    m1: float

    @classmethod
    def at(cls, t: float) -> Arch:
        """The arch with ln(m / m1) = t."""
        small = math.exp(-abs(t))
        near, far = small / (1.0 + small), 1.0 / (1.0 + small)
        return cls(far, near) if t > 0.0 else cls(near, far)

    @classmethod
    def of_angle(cls, angle: float) -> Arch:
        """The arch whose ends make `angle` with the chord [rad], 0 to pi exclusive."""
        return cls(math.sin(angle / 2.0) ** 2, math.cos(angle / 2.0) ** 2)

    @cached_property
    def k(self) -> float:
        """The modulus, sin(beta_0 / 2)."""
        return math.sqrt(self.m)

    @cached_property
    def K(self) -> float:
        """Complete integral of the first kind."""
        return float(complete_k(self.m, self.m1))

    @cached_property
    def E(self) -> float:
        """Complete integral of the second kind."""
        return float(complete_e(self.m, self.m1))

    @cached_property
    def excess_ratio(self) -> float:
        """(length - chord) / length, to full relative precision however small it is."""
        return 2.0 * self.m * float(complete_d(self.m, self.m1)) / self.K

    @property
    def angle(self) -> float:
        """beta_0 [rad]."""
        return 2.0 * math.atan2(self.k, math.sqrt(self.m1))

    @property
    def energy_ratio(self) -> float:
        """Strain energy times length per EI: 8 K (E - m1 K), formed without cancellation at small m."""
        return 8.0 * self.K * self.m * (self.K - float(complete_d(self.m, self.m1)))

    def size(self, datum: str) -> float:
        """What a length-like datum is in units of 1 / omega."""
        match datum:
            case "length":
                return 2.0 * self.K
            case "chord":
                return 2.0 * float(complete_2e_minus_k(self.m, self.m1))
            case "rise":
                return 2.0 * self.k
            case "bend_radius":
                return 0.5 / self.k
            case "force":
                return 1.0  # sqrt(EI / F) is the unit itself
            case _:
                raise KeyError(datum)


FIGURE_EIGHT = Arch(0.82611476598497033618, 0.17388523401502966382)
"""The arch whose ends meet, 2 E = K: end angle 130.70991070789999 degrees."""

HIGHEST = Arch(0.70132746066310042473, 0.29867253933689957527)
"""The arch with the greatest rise for its length, 0.40314018970565024 of it."""

WIDEST_BEND = Arch(0.35230205567376911206, 0.64769794432623088794)
"""The arch with the greatest chord for its least bend radius, 2.6055682448656876 of it."""

_TURNING = {
    frozenset({"length", "rise"}): (HIGHEST,),
    frozenset({"chord", "bend_radius"}): (WIDEST_BEND, FIGURE_EIGHT),
    frozenset({"chord", "rise"}): (FIGURE_EIGHT,),
    frozenset({"chord", "force"}): (FIGURE_EIGHT,),
}
"""Where the ratio of two data turns back or changes sign; between these arches it is monotonic in t."""

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
    candidates = [_scale(arch, primary, EI) for arch in _arches(primary, EI)]
    called = dict(names or {})
    verdicts = [_disagreements(candidate, rest, primary, EI, called) for candidate in candidates]
    chosen = next((i for i, (mistakes, _) in enumerate(verdicts) if not mistakes), 0)
    mistakes, notes = verdicts[chosen]
    if mistakes:
        raise SceneError(mistakes)
    answer = candidates[chosen]
    other = candidates[1] if chosen == 0 and len(candidates) > 1 and not rest else None
    return Pinned(answer.arch, answer.omega, answer.length, answer.chord, other, notes)


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
    open_share = (_EPS * primary["length"] + blur) / (primary["length"] - primary["chord"])
    if open_share < AGREEMENT:
        return primary, rest
    (arch,) = _arches(primary, EI)
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
        f"{called.get(key, key)} = {_shown(key, value, beside=other if value == one else one)}"
        for key, value in primary.items()
    )
    for key, value in rest.items():
        consistent = answer.datum(key, EI)
        scale = answer.length if key == "chord" else max(abs(value), abs(consistent))
        off = abs(value - consistent) / scale
        name = called.get(key, key)
        if off > AGREEMENT:
            shown = _shown(key, consistent, beside=value)
            problem = f"contradicts {basis}, which give {shown}; write that, or leave one of them out"
            mistakes.append(Mistake(name, problem, value))
        elif off > 1e-12:
            given, taken = _shown(key, value, beside=consistent), _shown(key, consistent, beside=value)
            notes.append(f"{name} = {given} was taken as {taken}, which {basis} give")
    return mistakes, tuple(notes)


def _shown(key: str, value: float, *, beside: float = math.nan) -> str:
    """A datum with its unit, in nine digits, or in as many as tell it from the number beside it."""
    text = f"{value:.9g}"
    if text == f"{beside:.9g}":
        text = repr(value).removesuffix(".0")
    return f"{text} {_UNITS.get(key, 'mm')}".rstrip()


def _scale(arch: Arch, primary: Mapping[str, float], EI: float | None) -> Pinned:
    """Give an arch the size its data ask for, keeping a given length and chord as they were given."""
    key = next(key for key in _SCALES if key in primary)
    value = _as_length(key, primary[key], EI)
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


def _as_length(key: str, value: float, EI: float | None) -> float:
    """A datum as a length [mm]: the force by sqrt(EI / F)."""
    if key != "force":
        return value
    if EI is None:
        raise ValueError("a force needs the bending stiffness EI")
    return math.sqrt(EI / value)


def _arches(primary: Mapping[str, float], EI: float | None) -> list[Arch]:
    """All arches that meet two data, by rising end angle; at least one."""
    if "slack" in primary:
        return [_of_excess(math.log(primary["slack"] / (1.0 + primary["slack"])))]
    if "angle_deg" in primary:
        return [Arch.of_angle(math.radians(primary["angle_deg"]))]
    if primary.keys() == {"length", "chord"}:
        return [_of_length_and_chord(primary["length"], primary["chord"])]
    (a, x), (b, y) = ((key, _as_length(key, value, EI)) for key, value in primary.items())
    if x == 0.0:  # only a chord can vanish, and it comes first in the order
        return [FIGURE_EIGHT]
    target = x / y
    if "force" in primary and {a, b} & {"length", "chord"} and abs(abs(target) / math.pi - 1.0) <= _ROUNDING:
        raise InfeasibleError(_out_of_reach(primary, EI))  # the Euler load itself leaves the amplitude open
    turning = [math.log(arch.m / arch.m1) for arch in _TURNING.get(frozenset(primary), ())]
    ends = [-_STEEPEST, *turning, _STEEPEST]
    found: list[float] = []
    for low, high in pairwise(ends):
        middle = Arch.at((low + high) / 2.0)
        if middle.size(a) / middle.size(b) * target > 0.0:
            t = _root(lambda t: _log_ratio(Arch.at(t), a, b) - math.log(abs(target)), low, high)
            if t is not None and t not in found:
                found.append(t)
    if not found:
        raise InfeasibleError(_out_of_reach(primary, EI))
    return [Arch.at(t) for t in found]


def _log_ratio(arch: Arch, a: str, b: str) -> float:
    ratio = abs(arch.size(a) / arch.size(b))
    return math.log(ratio) if ratio > 0.0 else -math.inf


def _of_excess(target: float) -> Arch:
    """The arch whose excess is e^target of its length, to full relative precision however small that is."""
    t = _root(lambda t: math.log(Arch.at(t).excess_ratio) - target, -_STEEPEST, _STEEPEST)
    if t is None:
        raise InfeasibleError(f"an excess of {math.exp(target):.3g} of the length is out of the range of numbers")
    return Arch.at(t)


def _of_length_and_chord(length: float, chord: float) -> Arch:
    """The arch with this length and signed chord, from the exact excess where the chord is long."""
    if abs(chord) >= length:
        raise InfeasibleError(
            f"length {length:.12g} mm is not more than the chord's {abs(chord):.12g} mm (it lacks "
            f"{abs(chord) - length:.3g} mm); make the cable longer or bring the ends together"
        )
    if chord > length / 2.0:
        return _of_excess(math.log((length - chord) / length))
    target = math.log((length + chord) / length / 2.0)
    t = _root(lambda t: math.log(Arch.at(t).E / Arch.at(t).K) - target, -1.0, _STEEPEST)
    if t is None:
        raise InfeasibleError(
            f"chord {chord:.9g} mm is below -0.994 of the length {length:.9g} mm: the cable would be a loop so tight "
            "that its shape is out of the range of numbers; choose a chord nearer to zero"
        )
    return Arch.at(t)


def _out_of_reach(primary: Mapping[str, float], EI: float | None) -> str:
    """Why no arch has two length-like data, with the bound that is passed."""
    data = " and ".join(f"{key} = {_shown(key, value)}" for key, value in primary.items())
    if primary.keys() == {"length", "force"} and EI is not None:
        load = EI * (math.pi / primary["length"]) ** 2
        return (
            f"{data}: the force does not exceed the Euler load {load:.7g} N of this length, so the cable stays "
            "straight; give a greater force, or the distance of the ends instead of the force"
        )
    if primary.keys() == {"chord", "force"} and EI is not None and primary["chord"] > 0.0:
        load = EI * (math.pi / primary["chord"]) ** 2
        return (
            f"{data}: a cable bent between pins at this distance carries less than {load:.7g} N, the Euler load of "
            "that distance; give a smaller force or a shorter chord"
        )
    bounds = {
        frozenset({"length", "rise"}): ("rise", HIGHEST.size("rise") / HIGHEST.size("length"), "length", "at most"),
        frozenset({"chord", "bend_radius"}): (
            "chord",
            WIDEST_BEND.size("chord") / WIDEST_BEND.size("bend_radius"),
            "bend_radius",
            "at most",
        ),
        frozenset({"rise", "bend_radius"}): ("rise", 4.0, "bend_radius", "less than"),
        frozenset({"rise", "force"}): ("rise", 2.0, "sqrt(EI / force)", "less than"),
        frozenset({"bend_radius", "force"}): ("bend_radius", 0.5, "sqrt(EI / force)", "more than"),
    }
    bound = bounds.get(frozenset(primary))
    if bound is None:
        return f"{data}: no cable pinned at both ends has both, within the range of numbers"
    what, factor, of, word = bound
    size = _as_length("force", primary["force"], EI) if of not in primary else primary[of]
    return (
        f"{data}: the {what} of a pinned cable is {word} {factor:.7g} of its {of}, here {word} {factor * size:.7g} mm"
    )


def _root(function: Callable[[float], float], low: float, high: float) -> float | None:
    """The root of a monotonic function between two ends, to the last digit of a double; None if there is none.

    An end at which the function vanishes to rounding is a root: the turning point of a pair with two answers.

    Source: T. R. Chandrupatla, A new hybrid quadratic/bisection algorithm, Adv. Eng. Softw. 28 (1997) 145-149. It
    stands here because scipy.optimize costs four times the import of numpy, and solving one cable must stay cheap.
    """
    a, b = high, low
    fa, fb = function(a), function(b)
    for end, value in ((low, fb), (high, fa)):
        if abs(value) <= _ROUNDING and abs(end) < _STEEPEST:
            return end
    if fa * fb > 0.0 or math.isnan(fa * fb):
        return None
    c, fc = a, fa
    share = 0.5
    for _ in range(200):
        x = a + share * (b - a)
        fx = function(x)
        if (fx > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, b, fc, fb = b, a, fb, fa
        a, fa = x, fx
        best, least = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        room = 2.0 * (_EPS * abs(best) + 1e-300) / abs(b - c)
        if room > 0.5 or least == 0.0:
            return best
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb) if math.isfinite(fc) else 2.0
        if math.isfinite(fb) and phi**2 < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        else:
            share = 0.5
        share = min(1.0 - room, max(room, share))
    return best
