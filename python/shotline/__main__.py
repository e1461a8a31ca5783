"""The command `shotline`, as the package installs it; also `python -m shotline`."""

import signal
import sys

from shotline import _native


def main() -> int:
    """Run the command line of this process and return its exit code."""
    # The command has its own way to end on Ctrl-C, and Python's handler would wait for it to return.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["shotline", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
