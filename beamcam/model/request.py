"""What is asked for: parts, how many of each, from which stock, on which machine, which marks.

Commands, folders and the Python interface all build a `Request`. The planner works from it, and
the read-back counts and lays out from the same record by itself. How a sheet lies (copies, mirror,
turn, origin) and what is done with a colour or layer are settings of the machine's torch for the
request.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from math import isfinite
from pathlib import PurePath
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.budget import check_pieces
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Marks, Policy
from beamcam.model.part import Bend, Camber, Contour, Feature, Hole, Part, TextMark
from beamcam.model.plan import Order
from beamcam.model.rounds import as_seen, is_unrolled, rolled

ChosenBy = Literal["order", "time"]
Quantity = Literal["file"] | int | None  #: as in the part's file, a number, or once as listed


class Remnant(Struct, frozen=True):
    """A bar in store that is there once."""

    length: float  #: mm
    section: str = ""  #: "" of any, where there is only one
    grade: str = ""

    def __str__(self) -> str:
        of = f"{self.section}/{self.grade}" if self.grade else self.section
        return f"{of}={self.length:g}" if of else f"{self.length:g}"


#: Of parts that share stock: machine, section (of plates the thickness), grade.
LotKey = tuple[str, object, str]


def remnant_of(text: str) -> Remnant:
    """`4300`, `UPN200=4300` or `UPN200/S235JR=4300`. Raises ValueError."""
    of, equals, length = text.rpartition("=")
    section, _, grade = of.partition("/")
    remnant = Remnant(float(length), section.strip(), grade.strip())
    if not (
        isfinite(remnant.length) and remnant.length > 0 and bool(equals) == bool(remnant.section)
    ):
        raise ValueError(text)
    return remnant


class Request(Struct, frozen=True):
    """The requirements of a job; nothing in it comes from a plan."""

    parts: tuple[Part, ...]  #: as they were read, in the order given
    machine: Machine
    skips: tuple[str, ...] = ()  #: kinds of features that may be missing, as `--allow-skips` names
    name: str = "program"  #: of the job, in its program and in messages
    order: Order = "given"  #: of the parts on the bar; "best" is any
    turn: bool = False  #: whether parts may lie turned
    stock: tuple[float, ...] = ()  #: lengths of the bars in store, mm, rising; none: as needed
    style: str | None = None  #: "chain" or "table" of triggers; the suffix of a step table
    quantity: Quantity = None
    strict: bool = False  #: whether warnings refuse
    verified: bool = True  #: whether programs are read back
    date: str = ""  #: for words of the machine; only where it is asked for
    remnants: tuple[float, ...] = ()  #: lengths of bars that are there once each, mm, rising
    by: ChosenBy = "order"  #: which of several machines is taken, of those that leave out as much


class Job(Struct, frozen=True, dict=True):
    """One program of a request: the pieces that lie on one bar or sheet."""

    request: Request
    pieces: tuple[int, ...]  #: of each piece the place of its part in `request.parts`
    bar: float | None = None  #: length, mm; None: as long as the pieces need
    number: int = 1  #: of the program among those of the request, which are
    of: int = 1  #: so many

    @property
    def machine(self) -> Machine:
        return self.request.machine

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The part of each piece, as its machine takes it: see `taken_by`.

        Where a quantity is asked for each is a piece by itself.
        """
        parts, single = self.request.parts, self.request.quantity is not None
        taken = {}
        for place in dict.fromkeys(self.pieces):
            part = replace(parts[place], quantity=1) if single else parts[place]
            taken[place] = taken_by(self.machine, part)
        return tuple([taken[place] for place in self.pieces])


def taken_by(machine: Machine, part: Part) -> Part:
    """A part as a machine takes it: on a bar line rounds lie as they are seen, not unrolled.

    Where it takes tubes, a plate that is the surface of one is the tube.
    """
    if machine.stock != "beam":
        return part
    part = rolled_on(machine, part)
    return as_seen(part) if part.profile.is_round else part


def rolled_on(machine: Machine, part: Part) -> Part:
    """A plate that is the surface of a pipe as the tube, where a bar line takes such; else as it
    is."""
    layout = machine.layout
    tubes = layout is not None and "RO" in layout.profiles and "RO" in machine.sections
    if not tubes or machine.stock != "beam" or (tube := rolled(part)) is part:
        return part
    across = round(tube.profile.height, 2)  # as exact as the width is written
    return replace(tube, profile=replace(tube.profile, height=across, width=across))


FLAT = 150.0  #: mm that flats are wide at most (EN 10058)


def stock_of(parts: Sequence[Part], unrolled: bool = False) -> Literal["beam", "sheet"]:
    """The kind of stock that parts are made of: a sheet if all of them are plates.

    A pipe that is written as a plate is one where it is to be cut `unrolled`.
    """
    flat = (p.profile.code == "B" and (unrolled or not is_unrolled(p.profile)) for p in parts)
    return "sheet" if parts and all(flat) else "beam"


def are_flats(parts: Sequence[Part]) -> bool:
    """Whether all parts are plates that a saw may cut to length from flats."""
    return bool(parts) and all(
        part.profile.code == "B" and part.profile.height <= FLAT and not is_unrolled(part.profile)
        for part in parts
    )


class Share(Struct, frozen=True):
    """The pieces of one program, and the bars that it may be cut from."""

    pieces: tuple[int, ...]  #: of each the place of its part in the request
    lengths: tuple[float, ...] = ()  #: mm, rising; none: as long as the pieces need


def number_of(part: Part, quantity: Quantity) -> int:
    """How often a part is made: as its file says, unless a number is given."""
    return quantity if isinstance(quantity, int) else part.quantity


def pieces_of(request: Request) -> tuple[int, ...]:
    """All pieces in the order given, each by the place of its part; without a quantity one each.

    So the planner counts them; the read-back counts by itself (`checks/job.py`). A line without a
    saw is fed one cut piece at a time and runs its program so often; a coper has a program for each
    bar that it takes a piece off. Raises LimitError for more than `limits.pieces`.
    """
    places, machine = range(len(request.parts)), request.machine
    if request.quantity is None or (machine.stock == "beam" and machine.saw is None):
        return tuple(places)
    counts = [number_of(part, request.quantity) for part in request.parts]
    check_pieces((part.source, count) for part, count in zip(request.parts, counts, strict=True))
    return tuple(place for place, count in zip(places, counts, strict=True) for _ in range(count))


def numbered(name: str, count: int) -> tuple[str, ...]:
    """The names of `count` programs: job.gcode, or job-1.gcode, job-2.gcode, ..."""
    if count == 1:
        return (name,)
    stem, dot, suffix = name.rpartition(".")
    if not stem:
        stem, dot, suffix = name, "", ""
    return tuple(f"{stem}-{number}{dot}{suffix}" for number in range(1, count + 1))


Progress = Callable[[int, int], None]  #: members done, members in all


class Selection(Struct, frozen=True):
    """Which members are meant; of each kind any of the values, and every kind that is given."""

    marks: frozenset[str] = frozenset()
    guids: frozenset[str] = frozenset()
    classes: frozenset[str] = frozenset()  #: IfcBeam or beam; naming a class also reads proxies
    assemblies: frozenset[str] = frozenset()

    @property
    def everything(self) -> bool:
        return not (self.marks or self.guids or self.classes or self.assemblies)


ALL = Selection()


class Options(Struct, frozen=True):
    """Options for reading members."""

    force: bool = False  #: contradictions are warnings
    kernel: bool = False  #: every distinct member is also built by the geometry kernel and compared
    bolts: bool = True  #: holes from bolts where the solids have none
    clearance: float | None = None  #: mm of a hole over its bolt; None is by the bolt's standard
    letter: bool = False  #: every member gets its mark as a text
    workers: int = 1  #: processes that read the members of a large model side by side
    apart: bool = False  #: the kernel builds in another process, which ends when its time is up


MarkFrom = Literal["mark", "drawing", "file", "position"]
MARKS_FROM: tuple[MarkFrom, ...] = ("mark", "drawing", "file", "position")
MarkKind = Literal["text", "points", "contours"]


def mark_kind(feature: Feature) -> MarkKind | None:
    """The key of `[marks]` that applies to a feature; None if it is not a mark.

    The process of a line in a drawing follows from its layer and colour, not from a policy.
    """
    # Asked of every curve of a drawing, where `isinstance` takes ten times as long to say no.
    if type(feature) is Hole:
        return "points" if feature.kind == "mark" else None
    if type(feature) is Contour:
        seen = feature.layer is not None or feature.colour is not None
        return None if seen or feature.process == "cut" else "contours"
    return "text" if type(feature) is TextMark else None


def policy_on(feature: Feature, marks: Marks) -> Policy | None:
    """A machine's policy for a mark, or for a bend or camber that is left; None for any other."""
    kind = mark_kind(feature)
    if kind is not None:
        policy: Policy = getattr(marks, kind)
        return policy
    if type(feature) is Bend or type(feature) is Camber:
        left = marks.bends if type(feature) is Bend else marks.cambers
        return "list" if left == "list" else None
    return None


def marked(parts: Iterable[Part], source: MarkFrom) -> tuple[Part, ...]:
    """Parts with the mark that stands elsewhere: as a drawing number, a file's name, a position.

    Offices that keep one word in the field of the mark have it there; the position is the third
    line of a DSTV header, the phase. Where nothing stands in that place the mark is kept.
    """
    if source == "mark":
        return tuple(parts)
    mark_of: Callable[[Part], str] = {
        "drawing": lambda part: part.drawing,
        "file": lambda part: PurePath(part.source.file.replace("\\", "/")).stem,
        "position": lambda part: part.phase,
    }[source]
    return tuple(replace(part, mark=mark_of(part) or part.mark) for part in parts)
