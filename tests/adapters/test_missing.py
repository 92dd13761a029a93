"""Adapters where their host or the kernel is missing: one clear error with the line to install it."""

from __future__ import annotations

import subprocess
import sys

import pytest


def error_of(module: str, *missing: str) -> str:
    """What importing a module says where others are not installed."""
    code = f"import sys\nsys.modules.update(dict.fromkeys({missing!r}))\nimport {module}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    return done.stderr


@pytest.mark.parametrize(("host", "name"), [("cadquery", "CadQuery"), ("build123d", "build123d")])
def test_a_missing_host_is_named_with_its_line(host, name):
    said = error_of(f"cablecad.adapters.{host}", host)
    assert said.endswith(f"cablecad.errors.MissingDependencyError: {name} is not installed: pip install {host}\n")


@pytest.mark.parametrize("host", ["cadquery", "build123d"])
def test_a_host_without_a_kernel_is_told_by_the_kernels_lines(host):
    pytest.importorskip(host)
    said = error_of(f"cablecad.adapters.{host}", "OCP")
    for line in ('pip install "cablecad[ocp]"', 'pip install "cablecad[novtk]"', "Never have both"):
        assert line in said
