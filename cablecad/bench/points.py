"""Points of a centreline: a wave of the elastica by our closed form, scipy's functions, Gauss-Legendre and an ODE.

The curve runs from u = -K to 3 K with |n| = EI = 1, so that u is arclength from the first crest: the paper's pinned
cable and, upside down, the same once more, as a cable between clamps goes on beyond an inflection. Every method is
given m1 and 1000 values of u and gives x = 2 E(u) - u and y = 2 k cn(u). The paper's rule knows one arch, so u is
brought back to it; scipy's functions are taken as they are, and once more with u brought back likewise, which their
documentation does not ask for. The error is taken at 513 points where mpmath gave the truth, over the length 4 K.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from cablecad.bench.clock import take_turns
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.table import Plot, Table, Target, column
from cablecad.bench.truth import Array, WaveTruth, wave_truths
from cablecad.rod.jacobian import Jacobian
from cablecad.rod.quadrature import gauss_amplitude, pinned_points

Method = Callable[[Array, float], Array]
"""Places (n, 2) at arguments (n,), ascending, of the cable with this m1."""

OURS, SCIPY = "cablecad", "scipy, ellipj + ellipeinc"
BROUGHT_BACK = "scipy, u brought back to one arch"
POINTS = 1000

WRONG = 1e-9
"""Error over length of a point that is wrong: a millionth of a millimetre in a metre."""

FEW = 0.01
"""Share of wrong points above which a method's time is no figure to compare with."""


@dataclass(frozen=True)
class PointsRow:
    """A method at one m1."""

    m1: float = column("m1", form=".0e")
    method: str = column("method")
    time: float = column("time", "ns/point", ".0f")
    error: float = column("greatest error over length", form=".1e")
    wrong: int = column("points off by 1e-9", form="d")
    over_scipy: float = column("time over scipy's", form=".2f")


def by_landen(u: Array, m1: float) -> Array:
    """Ours, as the pieces of a centreline do it."""
    f = Jacobian(1.0 - m1, m1)
    _, cn, _, swing = f(u)
    return np.stack([(2.0 * f.mean_dn2 - 1.0) * u + (2.0 * f.m) * swing, 2.0 * math.sqrt(1.0 - m1) * cn], axis=1)


def by_scipy(u: Array, m1: float) -> Array:
    """By scipy's functions, which take m alone."""
    from scipy.special import ellipeinc, ellipj

    m = 1.0 - m1
    _, cn, _, phi = ellipj(u, m)
    return np.stack([2.0 * ellipeinc(phi, m) - u, 2.0 * math.sqrt(m) * cn], axis=1)


def by_scipy_within(u: Array, m1: float) -> Array:
    """The same, u brought back to -K..K first."""
    return _by_arches(by_scipy, u, m1)


def by_quadrature(u: Array, m1: float, *, nodes: int) -> Array:
    """By the paper's rule: the amplitude by Newton's method, then its equations (13) and (20)."""

    def arch(u: Array, m1: float) -> Array:
        phi = gauss_amplitude(u, 1.0 - m1, m1, nodes=nodes)
        return pinned_points(phi, 1.0 - m1, m1, 1.0, nodes=nodes)[:, ::-1]

    return _by_arches(arch, u, m1)


def _by_arches(arch: Method, u: Array, m1: float) -> Array:
    """Points beyond -K..K by those within: 2 K further on the curve is the same, moved and upside down."""
    from scipy.special import ellipkm1

    quarter = float(ellipkm1(m1))
    turns = np.rint(u / (2.0 * quarter))
    place = arch(u - 2.0 * quarter * turns, m1)
    moved = 2.0 * float(arch(np.array([quarter]), m1)[0, 0])
    return np.stack([place[:, 0] + moved * turns, np.where(turns % 2.0 == 0.0, 1.0, -1.0) * place[:, 1]], axis=1)


def by_ode(u: Array, m1: float, *, tolerance: float) -> Array:
    """By integrating psi'' = -sin(psi), x' = cos(psi), y' = -sin(psi) from the crest, and mirroring."""
    from scipy.integrate import solve_ivp

    def slope(_: float, z: Array) -> Array:
        return np.array([z[1], -math.sin(z[0]), math.cos(z[0]), -math.sin(z[0])])

    k = math.sqrt(1.0 - m1)
    half, back = np.unique(np.abs(u), return_inverse=True)
    start = [0.0, 2.0 * k, 0.0, 2.0 * k]
    found = solve_ivp(slope, (0.0, half[-1]), start, "DOP853", t_eval=half, rtol=tolerance, atol=tolerance)
    x, y = found.y[2][back], found.y[3][back]
    return np.stack([np.sign(u) * x, y], axis=1)


METHODS: dict[str, Method] = {
    OURS: by_landen,
    SCIPY: by_scipy,
    BROUGHT_BACK: by_scipy_within,
    **{f"Gauss-Legendre, {n} nodes": partial(by_quadrature, nodes=n) for n in (4, 8, 16, 32)},
    **{f"DOP853, tolerance {t:.0e}": partial(by_ode, tolerance=t) for t in (1e-4, 1e-7, 1e-10, 1e-13)},
}


def run(effort: Effort, tell: Tell) -> list[Table]:
    """The stage."""
    truths = wave_truths()
    if effort.quick:
        truths = tuple(truth for truth in truths if truth.m1 in (0.9, 0.19, 1e-2, 1e-8, 1e-16))
    rows: list[PointsRow] = []
    for truth in truths:
        tell(f"points at m1 = {truth.m1:g}")
        rows += _rows(truth, effort.count(15, 5))
    return [
        Table(
            "points",
            "Points of a centreline, a wave of the elastica: time and error",
            rows,
            _targets(rows),
            (
                f"{POINTS} points a call, medians of {effort.count(15, 5)} calls in turn; error against mpmath at 513 "
                "points, largest component over the length",
                "scipy's ellipj is wrong beyond u = K for small m1, its ellipeinc at isolated points of any m1",
            ),
            Plot("time", "error", _series),
        )
    ]


def _series(row: PointsRow) -> str | None:
    """Families of methods at an ordinary curve and at one with k near 1."""
    if row.m1 not in (0.19, 1e-8) or row.method == BROUGHT_BACK:
        return None
    return f"{row.method.partition(',')[0]}, m1 = {row.m1:g}"


def _rows(truth: WaveTruth, repeats: int) -> list[PointsRow]:
    u = np.linspace(truth.u[0], truth.u[-1], POINTS)
    times = take_turns({name: partial(method, u, truth.m1) for name, method in METHODS.items()}, repeats)
    rows = []
    for name, method in METHODS.items():
        off = errors_of(method(truth.u, truth.m1), truth)
        wrong = int(np.count_nonzero(off > WRONG))
        taken = times[name]
        rows.append(PointsRow(truth.m1, name, taken / POINTS * 1e9, float(off.max()), wrong, taken / times[SCIPY]))
    return rows


def errors_of(place: Array, truth: WaveTruth) -> Array:
    """Largest component of what each place is off by, over the length; infinite for what is not a number."""
    off = np.abs(place - truth.place).max(axis=1) / (4.0 * truth.quarter)
    return np.where(np.isfinite(off), off, np.inf)


def _targets(rows: list[PointsRow]) -> list[Target]:
    ours = {row.m1: row for row in rows if row.method == OURS}
    theirs = {row.m1: row for row in rows if row.method == SCIPY}
    fair = [m1 for m1, row in theirs.items() if row.wrong <= FEW * len(wave_truths()[0].u)]
    whole = sum(ours[m1].time for m1 in fair) / sum(theirs[m1].time for m1 in fair)
    # Errors of a few units of rounding are one and the same error.
    excess = max(ours[m1].error / max(theirs[m1].error, 4.0 * 2.0**-52) for m1 in ours)
    least = min(ours)
    return [
        Target(
            f"points: time over scipy's pair, over the {len(fair)} m1 where it is right but for 1 % of points",
            whole,
            0.25,
        ),
        Target("points: error over scipy's, 4 eps at least, greatest of all m1", excess, 1.0),
        Target(f"points: our error over length at m1 = {least:g}", ours[least].error, 1e-14),
        Target(f"points: scipy's error over length at m1 = {least:g}", theirs[least].error, 1e-3, ">="),
    ]
