"""What chose the counts of the fit and of its measured deviation: ``python spline_counts.py``, about a minute.

1. `SAMPLES_A_SPAN` and the angles around the circle: by how much the sampled maximum misses the one of 100 samples a
   span and 180 angles. (The report promises 16 samples; the crest is in the middle of a span, where 4 find it too.)
2. `_AIM` and, of `knots`, `_LEAST_DENSITY`: knots and fits that are needed, over curves and tolerances. A second fit
   costs more than some knots; knots are bytes in every file.
3. `DEGREE`: poles by tolerance.

The product's own choice is marked with *.
"""

import math
import sys
import time

import numpy as np
from scipy.special import bernoulli

from cablecad.bench.tubes import RADII, wave
from cablecad.brep import fit as fitting
from cablecad.brep import knots
from cablecad.brep.bspline import end_orders, powers_of
from cablecad.centreline import Centreline
from cablecad.errors import GeometryError

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)


def say(line):
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def curves():
    for k, radius in RADII.items():
        yield wave(k), radius


def samples():
    say("samples a span, angles: the greatest share by which the sampled deviation is too small")
    for per_span, around in ((1, 64), (3, 64), (4, 64), (7, 64), (16, 64), (32, 64), (16, 4), (16, 16), (16, 128)):
        worst = 0.0
        for curve, radius in curves():
            for tolerance in (1e-3, 1e-6):
                piece = fitting.fit_centreline(curve, radius, tolerance=tolerance).pieces[0]
                worst = max(
                    worst,
                    1.0 - deviation(curve, piece, radius, per_span, around) / deviation(curve, piece, radius, 100, 180),
                )
        chosen = per_span == fitting.SAMPLES_A_SPAN and around == len(fitting._ANGLES)
        say(f" {'*' if chosen else ' '} {per_span}, {around}: {100.0 * worst:.2f} %")


def deviation(curve, piece, radius, per_span, around):
    """The distance of points of equal parameters, straight from its definition."""
    steps = np.arange(per_span) / per_span
    s = np.append((piece.knots[:-1, None] + np.diff(piece.knots)[:, None] * steps).ravel(), 1.0) * piece.length
    exact = curve.frames(s)
    p, n, b = np.split(piece.evaluate(s)[0] - np.hstack([exact.position, exact.normal, exact.binormal]), 3, axis=1)
    worst = 0.0
    for angle in np.linspace(0.0, 2.0 * math.pi, around, endpoint=False):
        off = p + radius * (math.cos(angle) * n + math.sin(angle) * b)
        worst = max(worst, float(np.linalg.norm(off, axis=1).max()))
    return worst


def counted(module, name, values):
    say(f"{name}: knots in all, fits in all (one a curve is the least), ms in all")
    chosen = getattr(module, name)
    interpolate = fitting._interpolate
    for value in values:
        setattr(module, name, value)
        fits = 0

        def count(*arguments):
            nonlocal fits
            fits += len(arguments[0])
            return interpolate(*arguments)

        fitting._interpolate = count
        spans, least = 0, 0
        begun = time.perf_counter()
        for curve, radius in curves():
            for tolerance in TOLERANCES:
                spans += fitting.fit_centreline(Centreline(curve.pieces), radius, tolerance=tolerance).spans
                least += 1
        taken = (time.perf_counter() - begun) * 1e3
        fitting._interpolate = interpolate
        say(f" {'*' if value == chosen else ' '} {value}: {spans}, {fits} ({least}), {taken:.0f}")
    setattr(module, name, chosen)


def degrees():
    say("degree: poles in all of k = 0.342, 0.8, 0.999, by tolerance from 1e-1 to 1e-9 mm, and fits in all")
    chosen = knots.DEGREE
    interpolate = fitting._interpolate
    for degree in (5, 7, 9, 11):
        order = degree + 1
        span_error = (2.0 - 0.5**degree) * abs(bernoulli(order)[order]) / math.factorial(order)
        for module in (knots, fitting):
            module.DEGREE, module.ORDER, module.SPAN_ERROR = degree, order, span_error
        knots._END_ORDERS = np.array(end_orders(degree))
        fitting._AT_SHARES = powers_of(fitting._SHARES, degree, 0)
        fits, texts = 0, []

        def count(*arguments):
            nonlocal fits
            fits += len(arguments[0])
            return interpolate(*arguments)

        fitting._interpolate = count
        for tolerance in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
            try:
                found = [fitting.fit_centreline(curve, radius, tolerance=tolerance) for curve, radius in curves()]
            except GeometryError:
                texts.append("rounding")
            else:
                texts.append(str(sum(len(fit.pieces[0].poles) for fit in found)))
        fitting._interpolate = interpolate
        say(f" {'*' if degree == chosen else ' '} {degree}: {', '.join(texts)}; {fits} (27)")


if __name__ == "__main__":
    samples()
    counted(fitting, "_AIM", (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7))
    counted(knots, "_LEAST_DENSITY", (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0))
    degrees()
