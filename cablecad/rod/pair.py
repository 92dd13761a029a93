"""The arches that meet two data of a cable pinned at both ends.

Two data give one equation for k, and then the scale. It is solved in t = ln(m / m1), in which m and m1 both keep their
relative precision, from an end angle of 1e-6 degrees to a chord of -0.99 lengths, where m1 = 3e-173.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise

from cablecad.errors import InfeasibleError
from cablecad.rod.arch import FIGURE_EIGHT, HIGHEST, WIDEST_BEND, Arch

EPS = 2.220446049250313e-16

_ROUNDING = 8 * EPS
"""Room for the rounding of given data at the edge of what is possible."""

_STEEPEST = 690.0
"""Largest |t|: m or m1 = 1e-300, at the edge of the doubles; a chord of -0.994 lengths, an angle of 1e-148 degrees."""

_UNITS = {"angle_deg": "degrees", "force": "N", "slack": ""}

_TURNING = {
    frozenset({"length", "rise"}): (HIGHEST,),
    frozenset({"chord", "bend_radius"}): (WIDEST_BEND, FIGURE_EIGHT),
    frozenset({"chord", "rise"}): (FIGURE_EIGHT,),
    frozenset({"chord", "force"}): (FIGURE_EIGHT,),
}
"""Where the ratio of two data turns back or changes sign; between these arches it is monotonic in t."""


def as_length(key: str, value: float, EI: float | None) -> float:
    """A datum as a length [mm]: the force by sqrt(EI / F)."""
    if key != "force":
        return value
    if EI is None:
        raise ValueError("a force needs the bending stiffness EI")
    return math.sqrt(EI / value)


def arches(primary: Mapping[str, float], EI: float | None) -> list[Arch]:
    """All arches that meet two data, by rising end angle; at least one."""
    if "slack" in primary:
        return [_of_excess(math.log(primary["slack"] / (1.0 + primary["slack"])))]
    if "angle_deg" in primary:
        return [Arch.of_angle(math.radians(primary["angle_deg"]))]
    if primary.keys() == {"length", "chord"}:
        return [_of_length_and_chord(primary["length"], primary["chord"])]
    (a, x), (b, y) = ((key, as_length(key, value, EI)) for key, value in primary.items())
    if x == 0.0:  # only a chord can vanish, and it comes first in the order
        return [FIGURE_EIGHT]
    target = x / y
    if "force" in primary and {a, b} & {"length", "chord"} and abs(abs(target) / math.pi - 1.0) <= _ROUNDING:
        raise InfeasibleError(out_of_reach(primary, EI))  # the Euler load itself leaves the amplitude open
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
        raise InfeasibleError(out_of_reach(primary, EI))
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


def out_of_reach(primary: Mapping[str, float], EI: float | None) -> str:
    """Why no arch has two length-like data, with the bound that is passed."""
    data = " and ".join(f"{key} = {shown(key, value)}" for key, value in primary.items())
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
    size = as_length("force", primary["force"], EI) if of not in primary else primary[of]
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
    if not fa * fb < 0.0:  # a limit that is not attained is no root
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
        room = 2.0 * (EPS * abs(best) + 1e-300) / abs(b - c)
        if room > 0.5 or least == 0.0:
            return best
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb) if math.isfinite(fc) else 2.0
        if math.isfinite(fb) and phi**2 < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        else:
            share = 0.5
        share = min(1.0 - room, max(room, share))
    return best


def shown(key: str, value: float, *, beside: float = math.nan) -> str:
    """A datum with its unit, in nine digits, or in as many as tell it from the number beside it."""
    text = f"{value:.9g}"
    if text == f"{beside:.9g}":
        text = repr(value).removesuffix(".0")
    return f"{text} {_UNITS.get(key, 'mm')}".rstrip()
