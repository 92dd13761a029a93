"""The true shape of a flexible cable, for CAD.

A cable between two connectors takes one definite shape: the one elasticity gives it. cablecad solves it as an elastic
rod, fits a B-spline to it, sweeps the cable's circle along it into an exact solid, and writes STEP beside the rigid
parts it was given.

    >>> import cablecad as cc
    >>> cable = cc.Cable("W1", diameter=4.0, length=350.0, start=cc.Pin((0, 0, 0)), end=cc.Pin((0, 120, 0)))
    >>> solution = cc.solve(cable)
    >>> round(solution.bend_radius_min, 3)
    58.622
    >>> solution.points(200).shape
    (200, 3)

`cc.build(cable)` makes the solid, `cc.write_step([...], "loom.step")` writes it. Lengths in mm, forces in N, moments in
N mm. Names are loaded when they are first used: importing cablecad loads neither numpy nor Open Cascade.
"""

from importlib import import_module

__version__ = "0.1.0"

_HOMES = {
    "cablecad.errors": (
        "CablecadError",
        "ExchangeError",
        "GeometryError",
        "InfeasibleError",
        "InvalidTubeError",
        "MissingDependencyError",
        "Mistake",
        "NotPlanarError",
        "RuleError",
        "SceneError",
        "SolveError",
        "UsageError",
    ),
    "cablecad.model": (
        "Cable",
        "Clamp",
        "EquilibriumKey",
        "Material",
        "NamedPort",
        "Part",
        "PartPort",
        "Pin",
        "Port",
        "Rotation",
        "Scene",
        "Section",
        "Toward",
    ),
    "cablecad.centreline": ("Arc", "Centreline", "Frames", "Line", "Placement"),
    "cablecad.rod.solution": ("EndState", "Equilibrium", "RodSolution"),
    "cablecad.scene": ("load_scene",),
    "cablecad.picture.render": ("render_scene",),
    "cablecad.pipeline": ("Built", "build", "build_scene", "solve", "solve_many", "write_step"),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = sorted([*_HOME, "__version__"])  # noqa: PLE0605 - a list, sorted


def __getattr__(name: str) -> object:
    if name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'cablecad' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
