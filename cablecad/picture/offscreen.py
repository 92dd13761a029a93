"""A window nobody sees, for VTK to draw in: without a display, and never with a crash where a library is missing.

VTK's wheels bring no OpenGL. On Linux they take the system's: EGL with or without a graphics card, or OSMesa. Where
neither is there VTK would end the process with a segmentation fault, so it is asked first.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from cablecad.errors import MissingDependencyError

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

INSTALL = """pictures need VTK and {problem}. Install it by one of
  pip install "cablecad[ocp]"              the Open Cascade that brings VTK along
  pip install "cablecad[novtk,render]"     the one without, and VTK beside it
Never have both cadquery-ocp and cadquery-ocp-novtk: they own the same files, and removing one breaks the other."""

OPENGL = """pictures need OpenGL and this machine has none that works without a display ({problem}). Install Mesa's, \
which needs no graphics card:
  apt-get install libegl1 libgl1-mesa-dri           Debian, Ubuntu
  dnf install mesa-libEGL mesa-dri-drivers          Fedora, Red Hat
  conda install -c conda-forge mesalib              without root, beside conda's Python"""

_OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


def load_vtk() -> None:
    """Load what pictures need of VTK.

    Raises:
        MissingDependencyError: It is not there; the message says what to install.
    """
    try:
        import vtkmodules.vtkRenderingCore
        import vtkmodules.vtkRenderingFreeType
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - both register themselves with VTK's factory
    except ModuleNotFoundError as error:
        lacks = sys.modules.get("vtkmodules") is not None
        problem = f"it lacks its part {error.name}" if lacks else "it is not installed"
        raise MissingDependencyError(INSTALL.format(problem=problem)) from error
    except ImportError as error:  # a library it is linked to
        raise MissingDependencyError(INSTALL.format(problem=f"it could not be loaded ({error})")) from error


def offscreen_window(width: int, height: int) -> vtkRenderWindow:
    """A window of a size in pixels, ready to draw in.

    Raises:
        MissingDependencyError: VTK or OpenGL is missing; the message says what to install.
    """
    load_vtk()
    from vtkmodules.vtkCommonCore import vtkLogger
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # VTK tells what it tried in vain
    with _no_display():
        window = vtkRenderWindow()
        _refuse_without_opengl(window)
        window.SetOffScreenRendering(1)
        window.SetMultiSamples(0)
        window.SetDPI(72)  # so that a point of type is a pixel
        window.SetSize(width, height)
        window.Initialize()
    if not window.SupportsOpenGL():
        raise MissingDependencyError(OPENGL.format(problem="what there is, is older than OpenGL 3.2"))
    return window


@contextmanager
def _no_display() -> Iterator[None]:
    """Keep VTK from an X server, which may be slow, far away, or unable to draw at all."""
    display = os.environ.pop("DISPLAY", None)
    try:
        yield
    finally:
        if display is not None:
            os.environ["DISPLAY"] = display


def _refuse_without_opengl(window: vtkRenderWindow) -> None:
    """VTK takes OSMesa last, without looking whether it is there."""
    kind = window.GetClassName()
    if kind == "vtkOSOpenGLRenderWindow" and not any(map(_loads, _OSMESA)):
        raise MissingDependencyError(OPENGL.format(problem="neither EGL nor OSMesa works"))
    if sys.platform.startswith("linux") and kind == "vtkXOpenGLRenderWindow":  # VTK before 9.4 knows nothing else
        raise MissingDependencyError(INSTALL.format(problem="the one installed is older than 9.4"))


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
