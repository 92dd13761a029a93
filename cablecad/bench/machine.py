"""What the figures were measured on and with."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from cablecad import __version__

_PACKAGES = ("numpy", "scipy", "cadquery-ocp", "cadquery-ocp-novtk", "cadquery", "build123d", "matplotlib")


def describe_machine() -> dict[str, str | int | float | None]:
    """Processor, cores, load and versions; None where something is not there or does not tell."""
    found: dict[str, str | int | float | None] = {
        "system": platform.platform(),
        "processor": _processor(),
        "cores": _cores(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "threads": os.environ.get("OPENBLAS_NUM_THREADS"),
        "python": platform.python_version(),
        "cablecad": __version__,
    }
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found


def machine_line(machine: dict[str, str | int | float | None]) -> str:
    """The same on a line, what is not there left out."""
    packages = [f"{name} {machine[name]}" for name in ("python", "cablecad", *_PACKAGES) if machine.get(name)]
    load = machine.get("load")
    busy = "" if not isinstance(load, float) else f", load {load:.1f}"
    return f"{machine['processor']}, {machine['cores']} cores{busy}, {machine['system']}; {', '.join(packages)}"


def _cores() -> int | None:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count()


def _processor() -> str:
    """The processor's name; Python's own answer is empty on Linux."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
