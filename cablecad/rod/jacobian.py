r"""The Jacobian elliptic functions of one parameter, or of a column of them: what depends on it worked out once.

One transformation does everything, the descending Gauss (Landen) transformation in arithmetic-geometric means:

    a' = (a + g)/2,  g' = sqrt(a g),  c' = (a - g)/2 = c^2/(4 a'),     from a = 1, g = sqrt(m1), c = sqrt(m).

The functions of parameter (c/a)^2 at the argument a u then follow from those of (c'/a')^2 at a' u. Held as
sn : cn = s : q with one constant s and a varying q, one step is

    den = q^2 + a a' s^2,   q_above = q dn,   dn_above = (q^2 + g a' s^2)/den,   Z += 2^i c' a' s q_above/den,

in which nothing is ever subtracted: this is why dn keeps its relative accuracy down to its minimum sqrt(m1), where
sqrt(m1 + m cn^2) has lost all digits, and why no switch to tanh and sech is needed (such a switch is wrong by O(1)
beyond u = K, however small m1 is). The steps begin at the bottom, where the functions are trigonometric, and climb.
Z is held over m, so that int cn^2 is as good for a circle (m = 0) as anywhere.

Source: Bulirsch, Numer. Math. 7 (1965) 78-90 (the steps for sn, cn, dn, and `cel2`); DLMF 22.7(i).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

# Dropping a modulus c/a scales u by 1 - (c/a)^2/4 and changes dn by at most (c/a)^2/2: half a unit of rounding here.
# What is held over m, whose next weight is c^2/(4 m a'), changes by as much over m, so that it decides.
_NEGLIGIBLE = 2.2e-16


class Functions(NamedTuple):
    """The elementary functions of one kind of number: on floats `math` is ten times faster than numpy."""

    sqrt: Callable[..., Any]
    sin: Callable[..., Any]
    cos: Callable[..., Any]
    tan: Callable[..., Any]
    tanh: Callable[..., Any]
    exp: Callable[..., Any]
    atan2: Callable[..., Any]
    rint: Callable[..., Any]


def _rint(x: float) -> float:
    return x - math.remainder(x, 1.0)  # not round(): a NaN stays a NaN


_SCALAR = Functions(math.sqrt, math.sin, math.cos, math.tan, math.tanh, math.exp, math.atan2, _rint)
_ARRAY = Functions(np.sqrt, np.sin, np.cos, np.tan, np.tanh, np.exp, np.arctan2, np.rint)

# One step of the transformation: the means a and g above it, the mean a below it, and the half difference c over m.
Step: TypeAlias = tuple[Any, Any, Any, Any]


def functions_of(x: Any) -> Functions:
    """The elementary functions for a float, or for an array."""
    return _SCALAR if isinstance(x, float) else _ARRAY


def some(condition: Any) -> bool:
    """Whether a condition holds anywhere."""
    return condition if condition is True or condition is False else bool(np.any(condition))


def descend(m: Any, m1: Any) -> tuple[list[Step], Any]:
    """The steps from (m, m1), m1 > 0, down to a negligible modulus, and the last mean, which is pi/(2 K)."""
    sqrt = functions_of(m1).sqrt
    steps: list[Step] = []
    a, g, c2_over_m, c_over_m = 1.0, sqrt(m1), m, 1.0
    one = isinstance(m1, float)
    while not steps or (c2_over_m > _NEGLIGIBLE * (a * a) if one else some(c2_over_m > _NEGLIGIBLE * (a * a))):
        # One always: zeta/m has a limit at m = 0.
        mean = 0.5 * (a + g)
        quarter = 0.25 / mean
        c_over_m = quarter * (c_over_m * (m * c_over_m) if steps else 1.0)  # c'/m, c' = c^2/(4 a'): (a - g)/2 cancels
        steps.append((a, g, mean, c_over_m))
        a, g, c2_over_m = mean, sqrt(a * g), c_over_m * (m * c_over_m)
    return steps, a


def cel2(m1: Any, a: Any, b: Any) -> Any:
    """Integral of (a cos^2 + b sin^2)/sqrt(cos^2 + m1 sin^2) over a quarter turn, m1 > 0 (Bulirsch's cel2).

    No term is subtracted while a, b >= 0.
    """
    sqrt = functions_of(m1).sqrt
    g, mean, below, a = sqrt(m1), 1.0, a, a + b
    while True:
        b = 2.0 * (below * g + b)
        below, last = a, mean
        mean = mean + g
        a = b / mean + a
        # Convergence is quadratic: what is left out after this step is the gap's square over 16, under eps/16.
        if not some(abs(last - g) > 1.5e-8 * last):
            return math.pi / 4.0 * a / mean
        g = 2.0 * sqrt(g * last)


class Climb(NamedTuple):
    """The functions of u before sn and cn are brought to length one.

    Attributes:
        s, q: sn : cn, of one sign each.
        dn: sqrt(1 - m sn^2).
        swing: (Jacobi's zeta function)/m: what an integral of a square goes beyond its mean.
        x: u in units in which the quarter period is pi/2.
    """

    s: Any
    q: Any
    dn: Any
    swing: Any
    x: Any


class Jacobian:
    """The functions of one parameter.

    Args:
        m: Parameter in [0, 1]; a float, or an array that broadcasts with the arguments.
        m1: 1 - m, above 0.

    Attributes:
        rate: pi/(2 K), the mean slope of the amplitude.
        mean_sn2: Mean of sn^2, (K - E)/(m K).
        mean_cn2: Mean of cn^2, (E - m1 K)/(m K), to an absolute rounding.
    """

    def __init__(self, m: Any, m1: Any) -> None:
        self.m, self.m1 = m, m1
        self._steps: list[tuple[Any, Any, Any]] = []
        lag, power = 0.0, 1.0
        steps, self.rate = descend(m, m1)
        for a_above, g_above, a, c_over_m in steps:
            lag = lag + power * (m * c_over_m) * c_over_m
            power *= 2.0
            self._steps.append((a_above * a, g_above * a, power * c_over_m * a))
        self._steps.reverse()
        self.mean_sn2, self.mean_cn2 = 0.5 + lag, 0.5 - lag

    def take(self, index: Any) -> Jacobian:
        """The functions of some of many parameters, given in an array."""
        some = object.__new__(Jacobian)
        some.m, some.m1, some.rate = self.m[index], self.m1[index], self.rate[index]
        some.mean_sn2, some.mean_cn2 = (np.asarray(mean)[index] for mean in (self.mean_sn2, self.mean_cn2))
        some._steps = [(aa[index], ga[index], weight[index]) for aa, ga, weight in self._steps]
        return some

    @cached_property
    def mean_dn2(self) -> Any:
        """Mean of dn^2: E/K."""
        return cel2(self.m1, 1.0, self.m1) * (2.0 / math.pi) * self.rate

    def _bottom(self, x: Any) -> tuple[Any, Any]:
        """s and q where the functions are trigonometric: sin and cos by the tangent of the half, a quarter of the cost.

        Both are too large by 1 + t^2, which no ratio of the steps sees.
        """
        t = functions_of(x).tan(0.5 * x)
        return t + t, self.rate - self.rate * (t * t)

    def climb(self, u: Any) -> Climb:
        """The functions of u, of any size and sign, of the broadcast shape."""
        x = self.rate * u
        s, q = self._bottom(x)
        s2 = s * s
        # Each step takes q from below, and q dn, which at the bottom are one; what it leaves is q dn of the next.
        q_dn, swing = q, 0.0
        for aa, ga, weight in self._steps:
            above = q * q
            below = s2 * aa
            below += above
            above += s2 * ga
            q, share = q_dn, q_dn / below
            q_dn = share * above
            share *= weight
            swing += share
        above /= below
        swing *= s
        return Climb(s, q, above, swing, x)

    def elementary(self, u: Any) -> tuple[Any, Any, Any]:
        """sn, cn and dn of u, without the integral."""
        s, q = self._bottom(self.rate * u)
        s2, dn = s * s, 1.0
        for aa, ga, _ in self._steps:
            squared = q * q
            q = q * dn
            dn = (squared + s2 * ga) / (squared + s2 * aa)
        norm = functions_of(s).sqrt(s2 + q * q)
        return s / norm, q / norm, dn

    def __call__(self, u: Any) -> tuple[Any, Any, Any, Any]:
        """sn, cn, dn and `Climb.swing` of u."""
        s, q, dn, swing, _ = self.climb(u)
        norm = functions_of(s).sqrt(s * s + q * q)
        return s / norm, q / norm, dn, swing
