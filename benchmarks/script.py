"""What the benchmarks have in common as commands of a shell: their arguments and their end."""

import argparse
import io
import os
import sys
from collections.abc import Callable


def arguments(doc: str | None) -> argparse.ArgumentParser:
    """A parser whose help is what a script says of itself, line for line."""
    return argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def at_least(least: int) -> Callable[[str], int]:
    """The type of an argument that is a whole number, `least` or more."""

    def number(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"found {text!r}; expected {least} or more")
        return int(text)

    return number


def start(main: Callable[[], None]) -> None:
    """Runs a script, each line of which is seen as soon as it is printed.

    A reader that has had enough, such as `head`, ends the script with 1 and without a word.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)
    try:
        main()
    except BrokenPipeError:
        # What is still in the buffer has no reader either, and Python would complain at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
