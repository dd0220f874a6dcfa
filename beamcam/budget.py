"""The budget of a run: how much one input may ask for, checked where amounts multiply.

A file of a kilobyte can say a thousand million pieces. Each limit is far above what a shop needs
and far below what a computer can take; `[limits]` of the configuration has other ones. They are
those of the process, like its memory, and change no program: what exceeds one is refused by name.
"""

from collections.abc import Iterable, Iterator
from math import inf
from threading import local
from time import thread_time
from typing import Annotated

from msgspec import Meta

from beamcam.conversion import Keys, Positive, PositiveCount
from beamcam.errors import BeamcamError, Diagnostic, Rule, Severity, Source

#: Deeper ones would need more of the interpreter's stack than some systems give a thread.
MAX_DEPTH = 300


class Limits(Keys, frozen=True):
    """How much a run may take."""

    pieces: PositiveCount = 100_000  #: of all parts together
    features: PositiveCount = 10_000  #: of the parts on one bar
    bytes: PositiveCount = 1_000_000_000  #: of one input, also when it is unpacked
    depth: Annotated[int, Meta(ge=1, le=MAX_DEPTH)] = 100  #: of blocks inserted in one another
    member_s: Positive = 5.0  #: of the processor for one member of a building model


class LimitError(BeamcamError):
    """A job that asks for more than the limits allow; no other machine would help it."""


class OverTimeError(Exception):
    """A member has had its time of the processor."""


class InForce:
    """What holds in this process, from the configuration on."""

    limits = Limits()
    until = local()  #: until when the member has time that each thread reads


def begin_member() -> None:
    """Begin to count the time of the processor that a member of a model takes, in this thread."""
    InForce.until.s = thread_time() + InForce.limits.member_s


def check_member() -> None:
    """Raises OverTimeError where the member has had its time."""
    if thread_time() > getattr(InForce.until, "s", inf):
        raise OverTimeError


def refused_pieces(counts: Iterable[tuple[Source, int]]) -> Iterator[Diagnostic | None]:
    """For each part with its quantity why it cannot be made with those before; None if it can.

    A part that is refused does not count.
    """
    most, total = InForce.limits.pieces, 0
    for source, count in counts:
        if total + count > most:
            beside = f" beside {total} of other parts" if total else ""
            yield PIECES.at(source, found=count, beside=beside, expected=most)
        else:
            total += count
            yield None


def check_pieces(counts: Iterable[tuple[Source, int]]) -> None:
    """Raises LimitError for parts with more pieces, all together, than the limits allow."""
    if refused := [one for one in refused_pieces(counts) if one is not None]:
        raise LimitError(refused)


def _limit(name: str, message: str, reason: str) -> Rule:
    advice = f"; expected at most {{expected}}, or another `limits.{name}` in beamcam.toml"
    return Rule(f"limit-{name.replace('_', '-')}", Severity.ERROR, f"{message}{advice}", reason)


PIECES = _limit(
    "pieces",
    "found {found} pieces{beside}",
    "Each piece is a label, a row of the cutting list and a place on a bar. A quantity of a "
    "thousand million is a damaged number.",
)
FEATURES = _limit(
    "features",
    "found {found} features on one bar, those of this part included",
    "A bar of 18 m has room for some thousands of holes. More are a drawing that was written again "
    "and again, and would be compared with each other for minutes.",
)
BYTES = _limit(
    "bytes",
    "found {found} bytes",
    "All of an input is read into memory, and takes some times as much there.",
)
DEPTH = _limit(
    "depth",
    "found the block {found!r} inserted in more blocks than that, each in the next",
    "Drawings nest a handful of blocks. Hundreds are made by a fault of an exporter.",
)
MEMBER = _limit(
    "member_s",
    "found a member that takes longer to be understood than it may",
    "Its solid is cut up by hundreds of faces that no section, hole or cut explains. Export it as "
    "a profile with openings, or leave it out by --mark or --guid of the others.",
)
