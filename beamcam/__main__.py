"""`python -m beamcam`, and the script `beamcam`.

Until the command begins, Ctrl-C ends the process at once: nothing is open yet, and modules that are
being imported would take the exception for a fault of their own. Nothing of beamcam is imported
before that is settled.
"""

import os
import signal

INTERRUPTED = 130  #: exit status after Ctrl-C, as shells have it


def end_at_once(*_: object) -> None:
    """End the process, as a handler of signals."""
    os._exit(INTERRUPTED)


def main() -> None:
    """Run the command line."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not where it is ignored
        signal.signal(signal.SIGINT, end_at_once)
    from beamcam.cli import main as command_line

    command_line.loading = end_at_once
    command_line(prog_name="beamcam")


if __name__ == "__main__":
    main()
