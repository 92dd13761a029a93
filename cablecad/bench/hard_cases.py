"""The cases that break solvers of planar rods, and what is to come out of them.

Expected energies (times length over EI) are published figures or were found to 26 digits without elliptic functions.
A case that has no shape is expected to be refused, for its reason.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from cablecad.errors import CablecadError, InfeasibleError, NotPlanarError
from cablecad.model import Cable, Clamp, Pin, Toward


@dataclass(frozen=True)
class HardCase:
    """One case.

    Attributes:
        name: What is hard about it.
        cable: Of length 1 mm where nothing else is said.
        energy: Expected least energy times length over EI; None where a refusal is expected.
        refusal: The error expected instead.
        stable: Expected verdict in the plane.
    """

    name: str
    cable: Cable
    energy: float | None = None
    refusal: type[CablecadError] | None = None
    stable: bool = True


def clamped(
    end: tuple[float, float], a: float, b: float, *, length: float = 1.0, scale: float = 1.0, **more: Any
) -> Cable:
    """A cable from the origin to `end`, its tangent turned by a and b degrees from x, all lengths times `scale`."""
    directions = [(math.cos(math.radians(x)), math.sin(math.radians(x)), 0.0) for x in (a, b)]
    more.setdefault("bulge", (1e-3, 1.0, 0.0))
    return Cable(
        "case",
        1e-6 * scale,
        Clamp((0.0, 0.0, 0.0), directions[0]),
        Clamp((end[0] * scale, end[1] * scale, 0.0), directions[1]),
        length=length * scale,
        **more,
    )


def pinned(end: Pin | Toward, **data: Any) -> Cable:
    """A cable pinned at the origin and at `end`, of length 1 unless told."""
    if "slack" not in data:
        data.setdefault("length", 1.0)
    return Cable("case", 1e-6, Pin((0.0, 0.0, 0.0)), end, **data)


def clamped_pinned(end: tuple[float, float], a: float) -> Cable:
    """A cable clamped at the origin at `a` radians from x and pinned at `end`."""
    start = Clamp((0.0, 0.0, 0.0), (math.cos(a), math.sin(a), 0.0))
    return Cable("case", 1e-6, start, Pin((*end, 0.0)), length=1.0, bulge=(1e-3, 1.0, 0.0))


def _taut(a: float, b: float, excess: float) -> float:
    """Energy of a taut cable to first order in sqrt(excess), from two boundary layers that do not know of each other.

    A layer that turns by psi under the tension omega^2 costs 4 omega (1 - cos(psi/2)) and shortens the chord by half
    of that over omega^2; the force points along the chord but for a turn of the order of the excess.
    """
    size = sum(1.0 - math.cos(math.radians(x) / 2.0) for x in (a, b))
    return 4.0 * size**2 / excess


AHEAD = Toward((1.0, 0.0, 0.0))
RING = 2.0 * math.pi**2

CASES = (
    HardCase("pinned, 20 degrees", pinned(AHEAD, angle_deg=20.0), 0.30103065262988087569512731565596),
    HardCase("pinned, k^2 = 1/2 (90 degrees)", pinned(AHEAD, angle_deg=90.0), 2.0 * math.pi),
    HardCase(
        "pinned, 160 degrees: crossed, unstable", pinned(AHEAD, angle_deg=160.0), 23.840303797216520397, stable=False
    ),
    HardCase("pinned, ends at one point (figure eight)", pinned(Pin((0.0, 0.0, 0.0))), 14.054951217665173671),
    HardCase("pinned, excess 1e-12 by slack", pinned(Pin((1.0, 0.0, 0.0)), slack=1e-12), math.pi**2 * 1e-12),
    HardCase("hook", clamped((1, 0), 90, 45, length=2.0), 9.045443190 * 2.0),
    HardCase("hairpin", clamped((0.3, 0), 90, -90), 9.136720278),
    HardCase("S offset (twins)", clamped((0.6, 0.3), 0, 0), 14.219524301),
    HardCase("coaxial (twins, turns about its axis)", clamped((0.8, 0), 0, 0), 8.322939530),
    HardCase("right angle", clamped((0.5, 0.5), 0, 90), 4.115276784),
    HardCase("U-turn, narrow", clamped((0, 0.2), 0, 180), 11.6429119108856),
    HardCase("U-turn, half circle without force", clamped((0, 2 / math.pi), 0, 180), math.pi**2 / 2),
    HardCase("U-turn, wide", clamped((0, 0.8), 0, 180), 6.96327646622448),
    HardCase("quarter circle without force", clamped((2 / math.pi, 2 / math.pi), 0, 90), math.pi**2 / 8),
    HardCase("parallel clamps, d = 0.9", clamped((0.9, 0), 0, 0), 4.05040889163451),
    HardCase("parallel clamps, d = 0.5 (symmetric starts miss it)", clamped((0.5, 0), 0, 0), 22.8023670460620),
    HardCase("parallel clamps, d = 0.1 (a loop below the S)", clamped((0.1, 0), 0, 0), 20.1369837863150),
    HardCase("closed ring", clamped((0, 0), 0, 0), RING),
    HardCase("closed ring, gap 0.001", clamped((0.001, 0), 0, 0), 19.739248280625930438),
    HardCase("opposite tangents at one point (twins)", clamped((0, 0), 0, 180), 18.3331074529547),
    HardCase(
        "tangents nearly backwards", clamped((0.5, 0), math.degrees(3.0), math.degrees(-3.0)), 27.760174468611505933
    ),
    HardCase("hair of slack, aligned, 1e-4", clamped((0.9999, 0), 0, 0), 0.0039479404601810179223),
    HardCase("hair of slack, aligned, 1e-6", clamped((0.999999, 0), 0, 0), 0.000039478427473965536668),
    HardCase("taut, d = 0.95", clamped((0.95, 0), math.degrees(0.6), math.degrees(-0.6)), 0.74354214369313996591),
    HardCase("taut, d = 0.97", clamped((0.97, 0), math.degrees(0.5), math.degrees(0.4)), 1.3289510202470948369),
    HardCase("taut, d = 0.99", clamped((0.99, 0), math.degrees(0.3), math.degrees(0.3)), 0.54301057721195516724),
    HardCase("taut, d = 1 - 1e-10", clamped((1.0 - 1e-10, 0), 20, -30), _taut(20.0, -30.0, 1.0 - (1.0 - 1e-10))),
    HardCase("clamped and pinned", clamped_pinned((0.7, 0.2), 0.5), 4.7743104007452762797),
    HardCase("clamped and pinned, across", clamped_pinned((0.1, 0.6), 0.0), 4.3374956079097581350),
    HardCase("no slack, aligned: a cylinder", clamped((1, 0), 0, 0), 0.0),
    HardCase("no slack, misaligned", clamped((1, 0), 10, 0), refusal=InfeasibleError),
    HardCase("length below the chord", clamped((1.01, 0), 0, 0), refusal=InfeasibleError),
    HardCase(
        "ends out of one plane",
        Cable("case", 1e-6, Clamp((0, 0, 0), (1, 0, 0.1)), Clamp((0.5, 0, 0), (1, 1, 0)), length=1.0),
        refusal=NotPlanarError,
    ),
    HardCase("micrometres", clamped((0.5, 0.5), 0, 90, scale=1e-6), 4.115276784),
    HardCase("kilometres", clamped((0.5, 0.5), 0, 90, scale=1e6), 4.115276784),
)
