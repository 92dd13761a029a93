"""Measures the accuracy the docstrings of `cablecad.rod.elliptic` promise: ``python elliptic_rounding.py``.

A bound on rounding needs far more points than mpmath can give. That the steps are the right ones is what
tests/rod/test_elliptic.py shows with mpmath; here the module and `jacobian` are run a second time with their float
type replaced by the 80-bit long double and the two are compared at 240 000 points a row, so that what differs is
rounding alone. Where long double is no wider than double (Windows, some ARM) there is nothing to measure.

Printed: the largest error in units of eps (1 + |u|), for dn, cn and sn also relative (see `jacobi`). Measured last with
numpy 2.4.6 on x86-64, over several seeds: jacobi 2.3, relative 4.3, F, E and argument 7.0; where m1 >= 1e-7 these are
2.2, 2.6 and 3.2.
"""

import math
import sys
from pathlib import Path
from types import ModuleType

import numpy as np

from cablecad.rod import elliptic, jacobian

EPS = float(np.finfo(float).eps)
SAMPLES = 20_000  # of each kind
WOBBLES = 4  # values of m1 a row
ROWS = (
    1.0,
    0.9,
    0.6,
    0.4,
    0.1,
    1e-2,
    1e-3,
    1e-5,
    1e-7,
    1e-9,
    1e-12,
    1e-16,
    1e-20,
    1e-30,
    1e-60,
    1e-100,
    3e-173,
    1e-300,
)
HEADER = "m1      sn   cn   dn   am   epsilon | relative: dn   cn   sn  | F    E    argument"


def in_long_double() -> ModuleType:
    """The elliptic module, and the one it climbs with, with every double in them a long double."""
    jacobian_wide, elliptic_wide = "jacobian_in_long_double", "elliptic_in_long_double"
    pi = ("math.pi", 'np.longdouble("3.14159265358979323846264338327950288")')
    _widened(
        jacobian_wide,
        jacobian,
        ("_NEGLIGIBLE = 2.2e-16", "_NEGLIGIBLE = np.longdouble(5e-20)"),
        ("> 1.5e-8 *", "> 1e-10 *"),
        pi,
    )
    return _widened(
        elliptic_wide,
        elliptic,
        ("np.float64", "np.longdouble"),
        ("from cablecad.rod.jacobian import", f"from {jacobian_wide} import"),
        pi,
    )


def _widened(name: str, plain: ModuleType, *changes: tuple[str, str]) -> ModuleType:
    source = Path(str(plain.__file__)).read_text(encoding="utf-8")
    for old, new in changes:
        if old not in source:
            message = f"{plain.__name__} no longer contains {old!r}: adapt this experiment"
            raise LookupError(message)
        source = source.replace(old, new)
    module = ModuleType(name)
    sys.modules[name] = module
    exec(compile(source, name, "exec"), module.__dict__)
    return module


def errors(m1: float, wide: ModuleType, rng: np.random.Generator) -> list[float]:
    """The largest errors at one parameter, in the order of HEADER."""
    m = 1.0 - m1
    long = np.longdouble
    exact_m1 = 1 - long(m) if m < 0.5 else long(m1)  # the smaller of the two is exact, as in the tests
    pair = np.array([1 - exact_m1]), np.array([exact_m1])
    quarter = elliptic.complete_k(m, m1)

    u = np.concatenate([rng.uniform(-reach, reach, SAMPLES) for reach in (3.0, 2 * quarter, 60 * quarter)])
    got, true = elliptic.jacobi(u, m, m1), wide.jacobi(u.astype(long), *pair)
    unit = EPS * (1 + abs(u))
    found = [(abs(a - b) / unit).max() for a, b in zip(got, true, strict=True)]
    slopes = (abs(true.sn) * true.dn, abs(true.cn) * true.dn)
    found.append((abs(got.dn / true.dn - 1) / unit).max())
    found.append((abs(got.cn - true.cn) / unit / np.maximum(abs(true.cn), slopes[0])).max())
    found.append((abs(got.sn - true.sn) / unit / np.maximum(abs(true.sn), slopes[1])).max())

    near_quarter = math.pi / 2 - 10.0 ** rng.uniform(-16, 0, SAMPLES)
    spread = [rng.uniform(-reach, reach, SAMPLES) for reach in (1.5707, 200.0)]
    phi = np.concatenate([near_quarter, *spread])
    first, second = (getattr(wide, name)(phi.astype(long), *pair) for name in ("incomplete_f", "incomplete_e"))
    found.append((abs(elliptic.incomplete_f(phi, m, m1) - first) / EPS / (1 + abs(first))).max())
    found.append((abs(elliptic.incomplete_e(phi, m, m1) - second) / EPS / (1 + abs(phi))).max())

    small = 10.0 ** rng.uniform(-150 if m1 < 1e-40 else -20, 0, SAMPLES)
    large = np.sqrt((1 - small) * (1 + small))
    sn0, cn0 = np.concatenate([large, small, large, -small]), np.concatenate([small, large, -small, -large])
    u0 = wide.argument(sn0.astype(long), cn0.astype(long), *pair)
    found.append((abs(elliptic.argument(sn0, cn0, m, m1) - u0) / EPS / (1 + abs(u0))).max())
    return [float(value) for value in found]


def main() -> int:
    if np.finfo(np.longdouble).eps > 1e-18:
        sys.stderr.write("long double is no wider than double here: nothing to measure\n")
        return 1
    rng = np.random.default_rng(0)
    wide = in_long_double()
    sys.stdout.write(HEADER + "\n")
    for row in ROWS:
        worst = np.max([errors(row * rng.uniform(0.97, 1.0), wide, rng) for _ in range(WOBBLES)], axis=0)
        sys.stdout.write(f"{row:.0e} " + " ".join(f"{value:.2f}" for value in worst) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
