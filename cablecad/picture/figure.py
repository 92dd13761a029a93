"""A sheet to plot on, by matplotlib: one style for all plots, no display, the same bytes for the same plot."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from cablecad.errors import MissingDependencyError
from cablecad.picture.palette import FAINT, INK, OKABE_ITO
from cablecad.picture.words import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FileFormat = Literal["png", "svg", "pdf"]
FILE_FORMATS: tuple[FileFormat, ...] = ("png", "svg", "pdf")

INSTALL = """plots need matplotlib and {problem}. Install it by
  pip install "cablecad[plot]\""""

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 11.0,
    "axes.titlesize": 13.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.8,
    "text.color": INK,
    "text.parse_math": False,  # a cable may be called $x
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.hashsalt": "cablecad",
    "svg.fonttype": "path",
    "path.simplify": False,
}

DOTS_PER_INCH = 150
"""Of plots in PNG."""

_EDGE = 0.12
"""White around everything on a sheet [inches]."""

STABLE = OKABE_ITO[0]
LEAVES_PLANE = "#b35a00"
UNSTABLE = "#6b7280"
"""Of equilibria: stable, stable only in their plane, and not even there. The dashes tell them apart as well."""


@contextmanager
def sheet(width: float, height: float) -> Iterator[Figure]:
    """A figure of a size in inches, in the style of all of them while the block lasts.

    Raises:
        MissingDependencyError: matplotlib is missing; the message says what to install.
    """
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ModuleNotFoundError as error:
        name = error.name or ""
        problem = "it is not installed" if name.startswith("matplotlib") else f"it lacks {name}"
        raise MissingDependencyError(INSTALL.format(problem=problem)) from error
    except ImportError as error:
        raise MissingDependencyError(INSTALL.format(problem=f"it could not be loaded ({error})")) from error
    with mpl.rc_context(), warnings.catch_warnings():
        mpl.rcdefaults()  # whatever a user's own matplotlibrc says
        mpl.rcParams.update(_STYLE)
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # a name in a script the type lacks
        from matplotlib.layout_engine import ConstrainedLayoutEngine

        layout = ConstrainedLayoutEngine(w_pad=_EDGE, h_pad=_EDGE)
        yield Figure(figsize=(width, height), layout=layout)


def plain_ticks(axes: Axes) -> None:
    """Numbers at both axes as they are, without an offset to add, and few enough for long ones."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    for axis, most in ((axes.xaxis, 6), (axes.yaxis, 8)):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.10g}".replace("-", "\N{MINUS SIGN}")))


def fitted_size(extent: tuple[float, float], *, beside: float = 1.1, above: float = 1.6) -> tuple[float, float]:
    """The sheet on which a drawing of equal scales leaves little white [inches].

    Args:
        extent: Width and height of what is drawn, in any unit.
        beside: What axis labels and the like need of the width [inches].
        above: What titles and the like need of the height [inches].
    """
    width, height = extent
    slope = min(max(height / width if width > 0.0 else 4.0, 0.2), 4.0)
    wide = min(7.4, 6.4 / slope)
    return max(wide + beside, 5.6), max(wide * slope + above, 3.4)


def file_bytes(figure: Figure, file_format: FileFormat) -> bytes:
    """The sheet as a file; called while the sheet's block lasts."""
    stream = io.BytesIO()
    if file_format == "png":
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from PIL import Image

        figure.set_dpi(DOTS_PER_INCH)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        # A plot has few colours: with a table of them its file is a third as large.
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3])
        picture.quantize(256, dither=Image.Dither.NONE).save(stream, format="png", optimize=True)
    else:
        metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None, "ModDate": None}}[file_format]
        figure.savefig(stream, format=file_format, metadata=metadata)
    return stream.getvalue()


def title_room(width: float) -> int:
    """Letters of a title on a sheet of a width [inches]."""
    return round(9.0 * (width - 0.8))


def subtitled(axes: Axes, title: str, subtitle: str) -> None:
    """A title at the left over the axes, and a line below it in a lighter tone; of each what there is room for."""
    width = axes.figure.get_figwidth()
    axes.set_title(shortened(title, title_room(width)), pad=26.0)
    axes.annotate(
        shortened(subtitle, round(12.5 * (width - 0.8))),
        (0.0, 1.0),
        xytext=(0.0, 9.0),
        xycoords="axes fraction",
        textcoords="offset points",
        color="#5b6470",
    )
