r"""Elliptic integrals and functions for real arguments, right at both ends of the parameter.

Every function takes the parameter m = k^2 *and* its complement m1 = 1 - m, both in [0, 1], both trusted: near m = 1
all the information is in m1, and 1 - m would lose it (a cable of chord/length = -0.99 has m1 = 3e-173). They need numpy
alone, broadcast as numpy does, return floats for floats, and raise `UsageError` where m or m1 is negative or their sum
is not 1. Notation: DLMF 19.2, 22.2.

The steps of `jacobian` do everything: `jacobi` climbs them, `argument` and the incomplete integrals run them downward.

Limits of the method: an integral of the amplitude is ill-conditioned near phi = pi/2 when m1 is small, since
dF/dphi = 1/sqrt(cos^2 + m1 sin^2) grows to 1/sqrt(m1). Work in the argument u (`jacobi`, `argument`), not in phi.

Source: Bulirsch, Numer. Math. 7 (1965) 78-90; DLMF 19.8(ii), 19.8(iii), 22.7(i).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from cablecad.errors import UsageError
from cablecad.rod.jacobian import Jacobian, cel2, descend, functions_of

Array: TypeAlias = NDArray[np.float64]
Floats: TypeAlias = "float | Array"
T = TypeVar("T", float, Array)

_TWO_PI = 2.0 * math.pi

# m + m1 = 1 holds to rounding in any sane call; a modulus passed for a parameter misses it by far more than this.
_SUM_TOLERANCE = 1e-9


class Jacobi(NamedTuple, Generic[T]):
    """The Jacobian elliptic functions of u, of the shape of the broadcast arguments.

    Attributes:
        sn: sin(am).
        cn: cos(am).
        dn: sqrt(1 - m sn^2), the derivative of am.
        am: Amplitude, growing without bound with u (am(2 K) = pi) [rad].
        epsilon: Jacobi's epsilon, the integral of dn^2 from 0 to u, which is E(am | m).
    """

    sn: T
    cn: T
    dn: T
    am: T
    epsilon: T


# --- complete integrals -------------------------------------------------------------------------------------------


def complete_k(m: T, m1: T) -> T:
    """K(m), the quarter period of sn; infinite at m1 = 0.

    Args:
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: relative, 4 eps for every m1 down to the least subnormal; ``test_complete_integrals``.
    """
    return _complete(m, m1, 1.0, 1.0, limit=math.inf)


def complete_e(m: T, m1: T) -> T:
    """E(m), the complete integral of the second kind; 1 at m1 = 0.

    Args:
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: as `complete_k`.
    """
    return _complete(m, m1, 1.0, _floats(m1), limit=1.0)


def complete_d(m: T, m1: T) -> T:
    """D(m) = (K - E)/m without the subtraction; pi/4 at m = 0, infinite at m1 = 0.

    What a nearly straight elastica needs: K - E = m D, and 1 - chord/length = 2 m D/K for a pinned one.

    Args:
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: as `complete_k`.
    """
    return _complete(m, m1, 0.0, 1.0, limit=math.inf)


def complete_2e_minus_k(m: T, m1: T) -> T:
    """2 E(m) - K(m): chord/length of a pinned elastica, times K; minus infinity at m1 = 0.

    It has a zero at m = 0.8261148 (the figure eight), about which only the absolute error is small.

    Args:
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: absolute, 4 eps (1 + K); ``test_complete_integrals``.
    """
    # The integrand (1 - 2 m sin^2)/Delta is (cos^2 + (2 m1 - 1) sin^2)/Delta.
    return _complete(m, m1, 1.0, 2.0 * _floats(m1) - 1.0, limit=-math.inf)


def _complete(m: T, m1: T, a: Any, b: Any, *, limit: float) -> T:
    """Integral of (a cos^2 + b sin^2)/sqrt(cos^2 + m1 sin^2) over a quarter turn; `limit` where m1 = 0."""
    value: T
    (value,) = _with_limit(*_parameters(m, m1), lambda _, m1: (cel2(m1, a, b),), lambda: (limit,))
    return value


# --- functions of the argument ------------------------------------------------------------------------------------


@overload
def jacobi(u: float, m: float, m1: float) -> Jacobi[float]: ...
@overload
def jacobi(u: Array, m: Floats, m1: Floats) -> Jacobi[Array]: ...
@overload
def jacobi(u: float, m: Array, m1: Array) -> Jacobi[Array]: ...
def jacobi(u: Floats, m: Floats, m1: Floats) -> Jacobi[Any]:
    """sn, cn, dn, am and Jacobi's epsilon of any finite real u, in one pass.

    Fast where m and m1 are floats: the steps' coefficients are then computed once for all of u.

    Args:
        u: Argument, of any size and sign.
        m: Parameter in [0, 1].
        m1: 1 - m; 0 gives tanh, sech, sech, the Gudermannian and tanh, and is used only where it is exactly 0.

    Returns:
        The five functions, of the broadcast shape; floats if all arguments are.

    Accuracy: absolute, 4 eps (1 + |u|), for m from 1e-300 to m1 = 3e-173, any sign, u to 60 quarter periods;
    ``test_jacobi_absolute_error``. Relative, 6 eps (1 + |u|): of dn to itself; of sn and cn to the larger of function
    and slope, as a rounding of u alone costs at their zeros; ``test_jacobi_relative_error``. Measured 2.3 and 4.3 by
    tests/experiments/elliptic_rounding.py, as are the figures of the functions below.
    """
    m, m1, u = *_parameters(m, m1), _floats(u)
    return Jacobi(*_with_limit(m, m1, lambda m, m1: _regular(u, m, m1), lambda: _jacobi_limit(u)))


def _regular(u: Any, m: Any, m1: Any) -> tuple[Any, ...]:
    """`jacobi` for m1 > 0."""
    parameter = Jacobian(m, m1)
    s, q, dn, swing, x = parameter.climb(u)
    f = functions_of(x)
    angle = f.atan2(s, q)
    am = angle + _TWO_PI * f.rint((x - angle) / _TWO_PI)  # am and x never differ by a quarter turn
    norm = f.sqrt(s * s + q * q)
    return s / norm, q / norm, dn, am, parameter.mean_dn2 * u + m * swing


def _jacobi_limit(u: Any) -> tuple[Any, ...]:
    f = functions_of(u)
    tanh = f.tanh(u)
    decay = f.exp(-abs(u))  # cosh(u) would overflow
    sech = 2.0 * decay / (1.0 + decay * decay)
    return tanh, sech, sech, f.atan2(tanh, sech), tanh


# --- functions of the amplitude -----------------------------------------------------------------------------------


@overload
def argument(sn0: float, cn0: float, m: float, m1: float) -> float: ...
@overload
def argument(sn0: Array, cn0: Array, m: Floats, m1: Floats) -> Array: ...
def argument(sn0: Floats, cn0: Floats, m: Floats, m1: Floats) -> Any:
    """The u0 in (-2 K, 2 K] with sn(u0) = sn0 and cn(u0) = cn0.

    sn0 = 0 with cn0 = -1 gives +2 K whatever the sign of the zero. At m1 = 0 the answer is infinite for cn0 <= 0.

    Args:
        sn0: Value of sn.
        cn0: Value of cn; sn0^2 + cn0^2 = 1 to rounding is trusted.
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: 4 eps (1 + |u0|), where m1 < 1e-7 8 eps (1 + |u0|), for the pair as given (measured 3.2 and 7.0);
    ``test_argument_there_and_back``.
    """
    m, m1 = _parameters(m, m1)
    s, c = _floats(sn0) + 0.0, _floats(cn0)  # adding 0.0 turns -0.0 into 0.0
    return _with_limit(m, m1, lambda m, m1: _integrals_from(s, c, m, m1)[:1], lambda: (_separatrix(s, c),))[0]


@overload
def incomplete_f(phi: float, m: float, m1: float) -> float: ...
@overload
def incomplete_f(phi: Array, m: Floats, m1: Floats) -> Array: ...
def incomplete_f(phi: Floats, m: Floats, m1: Floats) -> Any:
    """F(phi | m) for any finite real phi; at m1 = 0 infinite beyond a quarter turn.

    Args:
        phi: Amplitude, any number of turns [rad].
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: 4 eps (1 + |F|), where m1 < 1e-7 8 eps (1 + |F|), for phi as given; what a rounding of phi does near pi/2
    at small m1 is far more. ``test_incomplete_integrals``.
    """
    return _incomplete(phi, m, m1)[0]


@overload
def incomplete_e(phi: float, m: float, m1: float) -> float: ...
@overload
def incomplete_e(phi: Array, m: Floats, m1: Floats) -> Array: ...
def incomplete_e(phi: Floats, m: Floats, m1: Floats) -> Any:
    """E(phi | m) for any finite real phi.

    Args:
        phi: Amplitude, any number of turns [rad].
        m: Parameter in [0, 1].
        m1: 1 - m.

    Accuracy: 4 eps (1 + |phi|), where m1 < 1e-7 8 eps (1 + |phi|); ``test_incomplete_integrals``.
    """
    return _incomplete(phi, m, m1)[1]


def _incomplete(phi: Any, m: Any, m1: Any) -> tuple[Any, ...]:
    """F(phi | m) and E(phi | m)."""
    m, m1 = _parameters(m, m1)
    phi = _floats(phi)
    f = functions_of(phi)
    s, c = f.sin(phi), f.cos(phi)

    def limit() -> tuple[Any, Any]:
        half_turns = f.rint(phi / math.pi)  # 0 for the float next to pi/2, which is below pi/2
        within = half_turns == 0.0
        f_phi = _separatrix(np.where(within, s, phi), np.where(within, c, -1.0))
        return f_phi, 2.0 * half_turns + (1.0 - 2.0 * (half_turns % 2.0)) * s

    return _with_limit(m, m1, lambda m, m1: _integrals_from(s, c, m, m1, near=phi), limit)


def _integrals_from(s: Any, c: Any, m: Any, m1: Any, near: Any = None) -> tuple[Any, Any]:
    """F and E of the angle with sine s and cosine c, m1 > 0: the steps of `Jacobian.climb` run downward.

    Without `near` the angle is taken in (-pi, pi]; else it is the one closest to `near` [rad].
    """
    steps, bottom = descend(m, m1)
    q = c
    s2 = s * s
    f = functions_of(s2 * m1)
    dn = f.sqrt(c * c + m1 * s2)
    zeta = 0.0
    for i, (a_above, g_above, a, half_gap) in enumerate(steps, start=1):
        # dn^2 below, from the dn above, again without a difference
        dn = f.sqrt((a_above * dn + g_above) / ((1.0 + dn) * a))
        above, q = q, q / dn
        zeta = zeta + (2.0**i * m * half_gap * a) * above / (q * q + (a_above * a) * s2)
    angle = f.atan2(bottom * s, q)
    if near is not None:
        angle = angle + _TWO_PI * f.rint((near - angle) / _TWO_PI)
    u = angle / bottom
    return u, cel2(m1, 1.0, m1) * (2.0 / math.pi) * angle + zeta * s


def _separatrix(s: Any, c: Any) -> Any:
    """F of the angle with sine s and cosine c at m1 = 0, infinite from a quarter turn on."""
    reached = np.greater(c, 0.0)
    return _floats(np.where(reached, np.arcsinh(s / np.where(reached, c, 1.0)), np.copysign(math.inf, s)))


# --- arguments ----------------------------------------------------------------------------------------------------


def _floats(x: Any) -> Any:
    """A float, or an array of floats where x has a shape."""
    if isinstance(x, float | int) or np.ndim(x) == 0:
        return float(x)
    return np.asarray(x, dtype=np.float64)


def _parameters(m: Any, m1: Any) -> tuple[Any, Any]:
    """Floats or arrays of m and m1, checked."""
    m, m1 = _floats(m), _floats(m1)
    good = (m >= 0.0) & (m1 >= 0.0) & (abs(m + m1 - 1.0) <= _SUM_TOLERANCE)  # a NaN is not good
    if good is True or np.all(good):
        return m, m1
    first = np.argmin(good)
    at, at1 = (float(np.broadcast_to(x, np.shape(good)).flat[first]) for x in (m, m1))
    raise UsageError(
        f"elliptic parameter m = {at!r} with m1 = {at1!r}: both must be in [0, 1] and m + m1 = 1; "
        "give m = k^2, not the modulus k, and for m > 1 use the reciprocal parameter 1/m"
    )


def _with_limit(
    m: Any, m1: Any, regular: Callable[[Any, Any], tuple[Any, ...]], limit: Callable[[], tuple[Any, ...]]
) -> tuple[Any, ...]:
    """`regular(m, m1)`, but `limit()` wherever m1 is exactly 0."""
    if isinstance(m1, float):
        return limit() if m1 == 0.0 else regular(m, m1)
    flat = m1 == 0.0
    if not flat.any():
        return regular(m, m1)
    inner = regular(np.where(flat, 0.0, m), np.where(flat, 1.0, m1))
    return tuple(np.where(flat, at_limit, value) for at_limit, value in zip(limit(), inner, strict=True))
