"""Ctrl-C, from the first moment to the last.

Python raises KeyboardInterrupt wherever the program happens to be. In the second that Open Cascade takes to load,
that comes out as an ImportError, which reads as a kernel that is not installed. So the signal is also noted.
"""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn


class Interrupt:
    """The handler of SIGINT while the command line runs as a process of its own.

    Attributes:
        came: Whether Ctrl-C was pressed.
    """

    def __init__(self) -> None:
        self.came = False

    def __call__(self, _signal: int, _frame: FrameType | None) -> NoReturn:
        """Note the signal and stop what is running."""
        self.came = True
        raise KeyboardInterrupt

    def __enter__(self) -> None:
        """Listen, unless whoever started the process wants it left alone (`nohup`, a job in the background)."""
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self)

    def __exit__(self, *_error: object) -> None:
        """Be deaf: all is done, and unloading Open Cascade takes a third of a second more."""
        if signal.getsignal(signal.SIGINT) is self:
            signal.signal(signal.SIGINT, signal.SIG_IGN)


interrupt = Interrupt()
