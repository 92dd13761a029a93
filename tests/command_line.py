"""The command `cablecad`, whether or not it is on the path."""

import sys

COMMAND_LINE = [sys.executable, "-c", "from cablecad.cli import main; main()"]
