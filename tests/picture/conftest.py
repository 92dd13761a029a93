"""Pictures need a library of the system, which a machine may lack: then there is nothing to look at."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session")
def draws() -> None:
    """VTK can draw here."""
    from cablecad.errors import MissingDependencyError
    from cablecad.picture.offscreen import offscreen_window

    try:
        offscreen_window(16, 16)
    except MissingDependencyError as error:
        pytest.skip(str(error).partition("\n")[0])
