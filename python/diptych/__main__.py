"""The command `diptych`, also as `python -m diptych`."""

import signal
import sys

from ._engine import main as program


def main() -> int:
    # the program handles Ctrl-C itself: it stops at the end of a window and stores the run
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return program(["diptych", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
