"""The experiments behind the product's numbers still run, and still try the number that the product has."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

EXPERIMENTS = Path(__file__).parent / "experiments"


def printed(module, code):
    """What an experiment prints, in a process of its own: it gives the product other numbers."""
    done = subprocess.run(
        [sys.executable, "-c", f"import {module} as experiment\n{code}"],
        cwd=EXPERIMENTS,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def assert_each_tries_the_products_own(lines, blocks):
    """Each block, under a heading that is not indented, has one line with the mark."""
    headings = [line for line in lines if not line.startswith(" ")]
    assert len(headings) == blocks
    assert sum(bool(re.match(r" \* ", line)) for line in lines) == blocks
    assert len(lines) >= 3 * blocks


def test_counts_of_splines():
    pytest.importorskip("OCP", reason="solids need the kernel")
    lines = printed(
        "spline_counts",
        "experiment.samples()\n"
        "experiment.counted(experiment.fitting, '_AIM', (0.1, 0.7))\n"
        "experiment.counted(experiment.knots, '_LEAST_DENSITY', (0.05, 0.2))\n"
        "experiment.degrees()",
    )
    assert_each_tries_the_products_own(lines, 4)


def test_counts_of_the_planar_solver():
    lines = printed(
        "planar_counts",
        "experiment.COUNT = 4\n"
        "some = experiment.random_scenes(4, 1)\n"
        "best = experiment.solve(some, search='wide')[0]\n"
        "experiment.modes(some, best)\n"
        "experiment.sketches(some, best)\n"
        "experiment.bends(some, best)\n"
        "experiment.chunks(some)",
    )
    assert_each_tries_the_products_own(lines, 4)


def test_numbers_of_the_planar_search():
    lines = printed(
        "planar_search",
        "import numpy as np\nexperiment.COUNT = 4\n"
        "experiment.room(np.random.default_rng(1))\nexperiment.descent(np.random.default_rng(1))",
    )
    assert len(lines) == 1 + 14 + 1 + 16


def test_modes_of_margins():
    (line,) = printed(
        "margin_modes",
        "import numpy as np\nfound = experiment.differences((True, True), 4, 7)\n"
        "print(np.isfinite(found).all() and found[:, 0].max() > found[:, -1].max())",
    )
    assert line == "True"


def test_workers_of_a_batch():
    (line,) = printed("batch_workers", "print(experiment.seconds(2, 'none', 0) > 0.0)")
    assert line == "True"


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long double is no wider than double here")
def test_rounding_of_elliptic_functions():
    (line,) = printed(
        "elliptic_rounding",
        "experiment.SAMPLES = 50\n"
        "wide = experiment.in_long_double()\n"
        "print(max(experiment.errors(0.3, wide, experiment.np.random.default_rng(0))))",
    )
    assert 0.0 < float(line) < 16.0
