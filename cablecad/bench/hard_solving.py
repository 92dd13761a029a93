"""Hard cases of the planar solver, beside what scipy gives: closed forms for pins, collocation for clamps."""

from __future__ import annotations

import math
import time

import numpy as np

from cablecad.bench.collocation import boundary_value, naive_guess
from cablecad.bench.hard_cases import CASES, HardCase
from cablecad.bench.hard_row import HardRow, shortened
from cablecad.bench.scenes import TURN
from cablecad.errors import CablecadError
from cablecad.model import Cable, Clamp, Toward
from cablecad.rod.solve import solve_rod

ENERGY_ERROR = 2e-9
"""Relative error of an energy that counts as right: the digits the published figures have."""

RESIDUAL = 1e-12
"""Residual that counts as solved."""

RIVAL_ERROR = 1e-5
"""The same of a rival that was asked for 1e-6."""


def solving_rows() -> list[HardRow]:
    """A row a case."""
    solve_rod(CASES[10].cable)  # trial functions are made once in a process; no row shall pay for the others
    return [_row(case) for case in CASES]


def _row(case: HardCase) -> HardRow:
    rival, theirs = _scipy(case)
    begun = time.perf_counter()
    try:
        solution = solve_rod(case.cable)
        stable = bool(solution.stability.stable_in_plane)
    except CablecadError as error:
        taken = time.perf_counter() - begun
        right = case.refusal is not None and type(error) is case.refusal
        told = f"refused: {shortened(error)}"
        return HardRow(case.name, "no shape", "-", told, None, right, taken * 1e3, rival, theirs)
    taken = time.perf_counter() - begun
    energy = solution.equilibrium.energy_per_EI * solution.length
    error_of_it = None if case.energy is None else abs(energy - case.energy) / (case.energy or 1.0)
    right = (
        error_of_it is not None
        and error_of_it <= ENERGY_ERROR
        and solution.residual <= RESIDUAL
        and stable is case.stable
    )
    told = f"{energy:.10g}, {'stable' if stable else 'unstable'} in its plane"
    regime = solution.equilibrium.branch
    return HardRow(case.name, regime, solution.model, told, error_of_it, right, taken * 1e3, rival, theirs)


def _scipy(case: HardCase) -> tuple[str, str]:
    """The rival's name and its answer, judged."""
    with np.errstate(all="ignore"):
        if case.cable.is_pinned:
            return "scipy ellipk, ellipe, brentq", _judged(case, _pinned_energy(case.cable))
        start, end = case.cable.start_support, case.cable.end_support
        if isinstance(start, Clamp) and isinstance(end, Clamp) and not any(start.direction[2:] + end.direction[2:]):
            return "solve_bvp 1e-06, naive start", _judged(case, _clamped_energy(case.cable, start, end))
    return "-", "-"


def _judged(case: HardCase, energy: float) -> str:
    if not math.isfinite(energy):
        return "no answer"
    if case.energy is None:
        return f"{energy:.6g}: an answer where there is none"
    off = abs(energy - case.energy) / (case.energy or 1.0)
    if off <= RIVAL_ERROR:
        return f"right to {off:.0e}"
    return f"{energy:.6g}: wrong by {off:.0e}" if off < 1e-2 else f"{energy:.6g}: another shape"


def _pinned_energy(cable: Cable) -> float:
    """Energy times length over EI by the paper's closed form: 8 K (E - m1 K)."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipk

    if cable.angle_deg is not None:
        m = math.sin(math.radians(cable.angle_deg) / 2.0) ** 2
    else:
        assert not isinstance(cable.end_support, Toward)  # a chord was given
        chord = float(np.linalg.norm(np.subtract(cable.end_support.position, cable.start_support.position)))
        length = chord * (1.0 + cable.slack) if cable.slack is not None else float(cable.length or 0.0)
        try:
            m = float(brentq(lambda m: 2.0 * ellipe(m) / ellipk(m) - 1.0 - chord / length, 0.0, 0.999999, xtol=1e-300))
        except ValueError:
            return math.nan
    return float(8.0 * ellipk(m) * (ellipe(m) - (1.0 - m) * ellipk(m)))


def _clamped_energy(cable: Cable, start: Clamp, end: Clamp) -> float:
    """Energy times length over EI by collocation from a start that knows nothing."""
    length = float(cable.length or 0.0)
    a, b = (math.atan2(clamp.direction[1], clamp.direction[0]) for clamp in (start, end))
    place = np.subtract(end.position, start.position)[:2] / length
    turn = (b - a + np.pi) % TURN - np.pi
    return boundary_value(a, place, naive_guess(a, a + turn, place))().energy
