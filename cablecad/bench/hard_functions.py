"""Hard cases of the elliptic functions, beside scipy's."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from cablecad.bench.hard_row import HardRow
from cablecad.bench.truth import FunctionTruth, function_truths
from cablecad.rod.elliptic import complete_d, incomplete_e, jacobi

RIGHT = 1e-14
"""Error that counts as right, relative to 1 + |u| where an argument is given and to the value else."""

_NAMES = {"cn": "ellipj", "E(u)": "ellipj, ellipeinc", "E(phi)": "ellipeinc", "K - E": "ellipk - ellipe"}


def function_rows() -> list[HardRow]:
    """A row a value."""
    return [_row(truth) for truth in function_truths()]


def _row(truth: FunctionTruth) -> HardRow:
    begun = time.perf_counter()
    ours = _ours(truth)
    taken = time.perf_counter() - begun
    scale = abs(truth.value) if truth.name == "K - E" else 1.0 + abs(truth.u)
    error = abs(ours - truth.value) / scale
    theirs = abs(_scipys(truth) - truth.value) / scale
    argument = {"K - E": "m"}.get(truth.name, "phi" if truth.name == "E(phi)" else "u")
    given = f"m1 = {truth.m1:.3g}" if truth.name != "K - E" else "k to 0"
    return HardRow(
        case=f"{truth.name} at {argument} = {truth.u:.6g}, {given}",
        regime="k to 0" if truth.name == "K - E" else "k to 1" if truth.m1 < 1e-6 else "ordinary",
        model="elliptic functions",
        ours=f"{ours:.10g}",
        error=error,
        right=error <= RIGHT,
        time=taken * 1e3,
        rival=f"scipy {_NAMES[truth.name]}",
        theirs=f"off by {theirs:.0e}" if math.isfinite(theirs) else "not a number",
    )


def _ours(truth: FunctionTruth) -> float:
    u, m1 = truth.u, truth.m1
    of: dict[str, Callable[[], float]] = {
        "cn": lambda: float(jacobi(u, 1.0 - m1, m1).cn),
        "E(u)": lambda: float(jacobi(u, 1.0 - m1, m1).epsilon),
        "E(phi)": lambda: float(incomplete_e(u, 1.0 - m1, m1)),
        "K - E": lambda: float(u * complete_d(u, m1)),
    }
    return of[truth.name]()


def _scipys(truth: FunctionTruth) -> float:
    from scipy.special import ellipe, ellipeinc, ellipj, ellipk

    u, m = truth.u, 1.0 - truth.m1
    of: dict[str, Callable[[], float]] = {
        "cn": lambda: float(ellipj(u, m)[1]),
        "E(u)": lambda: float(ellipeinc(float(ellipj(u, m)[3]), m)),
        "E(phi)": lambda: float(ellipeinc(u, m)),
        "K - E": lambda: float(ellipk(u) - ellipe(u)),
    }
    with np.errstate(all="ignore"):
        return of[truth.name]()
