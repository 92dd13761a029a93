"""The plots of a scene: which files there are, and what is on each."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from cablecad.picture.curvature_plot import plot_curvature
from cablecad.picture.equilibria_plot import equilibria_size, plot_equilibria
from cablecad.picture.family_plot import Member, family_size, plot_family
from cablecad.picture.figure import FileFormat, file_bytes, sheet
from cablecad.picture.palette import cable_color, on_paper
from cablecad.picture.shape_plot import plot_shape, shape_size

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cablecad.rod.solution import RodSolution

_UNSAFE = re.compile(r"[^\w.+=-]+")
"""What no file name should have: slashes, blanks, quotes; letters of all scripts may stay."""


KINDS = ("shape", "curvature", "equilibria")
"""Of the plots of a cable."""


@dataclass(frozen=True)
class Plot:
    """A plot that is still to be drawn.

    Attributes:
        name: Of its file, without suffix.
        size: Width and height [inches].
        draw: Draws it on a sheet of that size.
    """

    name: str
    size: tuple[float, float]
    draw: Callable[[Figure], None]

    def data(self, file_format: FileFormat) -> bytes:
        """The file.

        Raises:
            MissingDependencyError: matplotlib is missing.
        """
        with sheet(*self.size) as figure:
            self.draw(figure)
            return file_bytes(figure, file_format)


def cable_plots(solutions: Sequence[RodSolution], kinds: Collection[str] = KINDS) -> Iterator[Plot]:
    """The plots of cables: shape, curvature and equilibria of each, or some of these `KINDS`."""
    taken: set[str] = set()
    for i, solution in enumerate(solutions):
        stem = file_stem(solution.cable.name, taken)
        color = on_paper(cable_color(solution.cable.color, i))
        if "shape" in kinds:
            yield Plot(f"{stem}-shape", shape_size(solution), partial(plot_shape, solution=solution, color=color))
        if "curvature" in kinds:
            yield Plot(f"{stem}-curvature", (8.0, 4.5), partial(plot_curvature, solution=solution, color=color))
        if "equilibria" in kinds:
            yield Plot(f"{stem}-equilibria", equilibria_size(solution), partial(plot_equilibria, solution=solution))


def family_plots(
    name: str, place: str, steps: Sequence[str | int], members: Sequence[Member], missing: int
) -> Iterator[Plot]:
    """The plot of a family of the cable `name`: `steps` lead from it to the value that changes, at `place`."""
    stem = file_stem("-".join([name, *map(str, steps)]), set())
    yield Plot(
        f"{stem}-family", family_size(members), lambda figure: plot_family(figure, name, place, members, missing)
    )


def file_stem(name: str, taken: set[str]) -> str:
    """A cable's name as a file may have it, and no other file has; it is added to those taken."""
    stem = safe = _UNSAFE.sub("_", name).strip("._")[:80] or "cable"
    number = 2
    while stem.casefold() in taken:
        stem = f"{safe}_{number}"
        number += 1
    taken.add(stem.casefold())
    return stem
