"""From a model's bytes to parts: candidates, shares of members, bolts, ledger."""

from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import TypeVar

from msgspec.structs import replace

from beamcam.budget import InForce
from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Part, TextMark
from beamcam.model.request import Options, Progress, Selection
from beamcam.processes import Died, Pool
from beamcam.readers import Reading
from beamcam.readers.ifc import member, rules
from beamcam.readers.ifc.entities import NOT_WELL_FORMED, RELATIONS, Model, open_file, tied
from beamcam.readers.ifc.member import KernelNeeded, Members, Taken
from beamcam.readers.ifc.text import Malformed
from beamcam.system import start_method

# --- shares ---------------------------------------------------------------------------------------
# Members of a model, read by several processes side by side.
#
# A forked process has the whole model at hand without a copy of it; one that is started afresh
# opens the model again. Both send back only the parts that they made. This is for callers who say
# that they may: one with threads of its own may not fork.

T = TypeVar("T")

SHARE = 16  #: members that are taken at a time, as reading one takes less than a millisecond
#: Members from which on processes pay, by how they are started and whether the kernel builds each
#: one. It is not to be interrupted, so that where processes cost little it is never called here.
WORTH = {
    ("fork", False): 192, ("fork", True): 1, ("spawn", False): 10_000, ("spawn", True): 50,
}  # fmt: skip


def workers_for(options: Options, count: int) -> int:
    """Number of processes for so many members; 0 to read them in this process."""
    if options.apart and options.kernel and start_method() == "fork":
        return options.workers
    worth = options.workers > 1 and count >= WORTH[start_method(), options.kernel]
    return options.workers if worth else 0


def shares(
    share: Callable[[range], T],
    died: Callable[[int], T],
    count: int,
    workers: int,
    each_by_itself: bool,
    begin: Callable[[], object] | None = None,
) -> Iterator[T]:
    """What `share` gives for all of range(count), a share at a time and in order.

    With `workers` above 0 so many processes do it, each of which calls `begin` first, and `share`
    has to give what can be pickled. Without, one does what raises KernelNeeded here. `died` gives
    what stands for a member at which processes die.
    """
    size = 1 if each_by_itself or not workers else SHARE
    todo = deque(range(i, min(i + size, count)) for i in range(0, count, size))
    most_s = (size + 4) * InForce.limits.member_s  # the kernel does not look at the clock
    pool = Pool[range, T](share, max(min(workers, len(todo)), 1), begin, most_s)
    made: dict[int, tuple[int, T]] = {}
    place = 0
    try:
        while place < count:
            if todo and pool.has_room():
                members = todo.popleft()
                if not workers:
                    with suppress(KernelNeeded):
                        made[members.start] = members.stop, share(members)
                if members.start not in made:
                    pool.submit(members)
            else:
                for members, result in pool.wait():
                    if not isinstance(result, Died):
                        made[members.start] = members.stop, result
                    elif len(members) == 1:
                        made[members.start] = members.stop, died(members.start)
                    else:
                        todo.extendleft(range(i, i + 1) for i in members)
            while place in made:
                place, done = made.pop(place)
                yield done
    finally:
        pool.close()


def read_model(
    data: bytes, name: str, selection: Selection, options: Options, progress: Progress | None
) -> Reading:
    """As `beamcam.readers.ifc.read`."""
    opened = open_file(data, Source(name))
    if isinstance(opened, Diagnostic):
        return Reading("ifc", (), (opened,))
    try:
        return _read(opened, name, selection, options, progress)
    except Malformed as fault:  # of a record that was not looked at before
        fatal = rules.SYNTAX.at(Source(name, fault.line), found=str(fault))
    except RecursionError:
        fatal = rules.SYNTAX.at(Source(name), found="values too deep inside one another")
    finally:
        opened.file.close()
    return Reading("ifc", (), (fatal,))


def _read(
    model: Model, name: str, selection: Selection, options: Options, progress: Progress | None
) -> Reading:
    members = Members.of(model, name, selection, options)
    elements = members.elements
    taken, workers = Taken(), workers_for(options, len(elements))
    members.may_build = not options.apart
    if workers:  # relations are not for each process to find
        with suppress(*NOT_WELL_FORMED):
            for what in RELATIONS:
                tied(elements[0], what)
    each = (members.share, members.died, len(elements), workers, options.kernel)
    for share in shares(*each, members.build_here):
        taken.add(share)
        if progress is not None:
            progress(taken.verdicts.total(), len(elements))
    parts = [part for _, part, _ in taken.members]
    if options.bolts and parts:
        from beamcam.readers.ifc.bolts import drill_bolt_holes

        shapes = [(elements[place], part, shaped) for place, part, shaped in taken.members]
        parts, remarks = drill_bolt_holes(model, shapes, options, name)
        taken.diagnostics += remarks
        taken.verdicts["refused"] += len(shapes) - len(parts)
        taken.verdicts["read"] = len(parts)
    diagnostics = *taken.diagnostics, *_account(members, taken)
    if options.letter:
        parts = [lettered(part) for part in parts]
    return Reading("ifc", tuple(parts), diagnostics)


LETTER_X, LETTER_HEIGHT = 100.0, 10.0  #: mm, of a mark that a model gives no place


def lettered(part: Part) -> Part:
    """A part with its mark as a text near its start, in the middle of the web or plate."""
    if not part.mark.strip():
        return part
    x = min(LETTER_X, part.length / 4)
    y = (part.profile.face_width("v") - LETTER_HEIGHT) / 2
    text = TextMark("v", x, y, 0.0, LETTER_HEIGHT, part.mark, part.source)
    return replace(part, features=(*part.features, text))


def _account(members: Members, taken: Taken) -> Iterator[Diagnostic]:
    """Selections without a match, members left out, and the ledger, which has to balance."""
    source, verdicts = Source(members.name), taken.verdicts
    for kind, chosen in member.KINDS.items():
        there = taken.seen.get(kind, set())
        names = {name for one in there for name in member.names_of(kind, one)}
        for value in sorted(getattr(members.selection, chosen)):
            if (member.plain_class(value) if kind == "class" else value) not in names:
                some = ", ".join(sorted(filter(None, there))[:5]) or "none"
                yield rules.NOT_FOUND.at(source, kind=kind, found=value, expected=some)
    for what in sorted({what for what, _ in taken.left_out}):
        left = Counter({kind: n for (of, kind), n in taken.left_out.items() if of == what})
        yield rules.LEFT_OUT.at(source, found=left.total(), what=what, classes=_counted(left))
    others, *parts = (
        Counter(one.is_a() for one in members.model.file.by_type(name))
        for name in ("IfcElement", "IfcFeatureElement", "IfcElementAssembly")
    )
    for counts in parts:
        others -= counts
    for kind in {element.is_a() for element in members.elements}:
        del others[kind]
    if others:
        yield rules.OTHER_CLASSES.at(source, found=others.total(), classes=_counted(others))
    if unknown := members.model.file.unknown_classes():
        figures = {"found": unknown.total(), "classes": _counted(unknown)}
        yield rules.UNKNOWN_CLASS.at(source, **figures, expected=members.model.file.schema)
    if verdicts.total() != len(members.elements):
        raise AssertionError("the ledger of the model does not balance")
    numbers = {verdict: verdicts[verdict] for verdict in member.VERDICTS}
    if numbers["left_out"] == verdicts.total():
        yield rules.NO_MEMBERS.at(source)
    yield rules.LEDGER.at(source, found=verdicts.total(), **numbers)


def _counted(counts: Counter[str]) -> str:
    """IfcBeam 3, IfcColumn 1"""
    rows = sorted(counts.items(), key=lambda row: (-row[1], row[0]))
    return ", ".join(f"{kind} {count}" for kind, count in rows)
