"""The work of a batch over stock, as workers do it: files looked at, shares of stock posted."""

from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from hashlib import sha256

from msgspec.structs import replace

from beamcam.arguments import on_best_machine
from beamcam.batch.names import FileNames, cleaned, folded
from beamcam.batch.part_rows import part_row
from beamcam.batch.work import BatchSettings, FileResult, Task, parts_in, posted_of
from beamcam.errors import BeamcamError
from beamcam.files import REFUSED_SUFFIX
from beamcam.model.part import Part
from beamcam.model.part_json import part_to_json
from beamcam.model.plan import stock_used
from beamcam.model.request import Request, Share, number_of
from beamcam.pipeline import Begun, begin_share, plans_of
from beamcam.reports.part_list import PartCount, manual_work_of
from beamcam.reports.run import StockRow, dumped
from beamcam.system import free_of_devices


class FileState(Task, frozen=True):
    """One file to be looked at: which machine makes each of its parts."""

    def post(self, settings: BatchSettings, made: FileResult) -> Generator[str, None, None]:
        """Add each part with the first machine that makes it; those that none makes refuse."""
        parts = parts_in(self, settings, made)
        yield "read the file"
        stock = settings.request.stock
        if stock:
            stock = tuple(sorted({*stock, *(one.length for one in settings.remnants)}))
        for part in parts:
            count = PartCount(part, number_of(part, settings.request.quantity or "file"))
            request = replace(settings.request_of(part), quantity=1, stock=stock)
            try:
                (planned, *_), choice = on_best_machine(
                    request, settings.machines_for(part), plans_of
                )
            except BeamcamError as error:
                made.refuse(error.diagnostics)
                made.looked.append(replace(count, refused=tuple(error.diagnostics)))
                continue
            made.say(choice)
            machine, work = planned.job.machine.name, manual_work_of(planned.plan)
            made.looked.append(replace(count, machine=machine, manual_work=work))


class ShareTask(Task, frozen=True):
    """The pieces of one bar or sheet to be made; its name is that of the program."""

    parts: tuple[Part, ...]
    pieces: tuple[int, ...]  #: of each the place of its part
    machine: str
    lengths: tuple[float, ...]  #: of the bar
    program: tuple[int, int]  #: which one of its lot, and of how many

    def post(self, settings: BatchSettings, made: FileResult) -> Generator[str, None, None]:
        """Add the program."""
        planned = self.planned(settings)
        yield "planned"
        posted = yield from posted_of(planned, lambda: self.name + REFUSED_SUFFIX, made)
        if posted is None:
            return
        content = posted.text.encode("utf-8")
        made.outputs.append((self.name, content))
        marks = Counter(self.parts[place].mark or "part" for place in self.pieces)
        named = " + ".join(f"{n} x {mark}" if n > 1 else mark for mark, n in marks.items())
        stock, plan = None, posted.plan
        length = 0.0
        if (used := stock_used(plan, posted.job.bar)) is not None:
            length = round(sum(piece.part.length for piece in plan.pieces), 6)
            stock = StockRow(
                remnant=used.remnant, cuts=used.cuts,
                pieces=[{"piece": p.given, "at": p.start, "turn": p.turn} for p in plan.pieces],
            )  # fmt: skip
        row = part_row(posted, self.name, content, settings.timed)
        row["mark"], row["quantity"] = named, len(self.pieces)
        row["length"], row["stock"] = length, stock
        made.row["parts"].append(row)

    def planned(self, settings: BatchSettings) -> Begun:
        """The program, planned. Raises PlanError."""
        request = replace(
            settings.request_of(self.parts[0]), parts=self.parts,
            machine=settings.machine_named(self.machine),
            quantity=settings.request.quantity or "file",
        )  # fmt: skip
        return begin_share(request, Share(self.pieces, self.lengths), program=self.program)

    @property
    def key(self) -> bytes:
        """A hash of all that its program depends on besides the shop."""
        parts = [part_to_json(part) for part in self.parts]
        rest = (self.pieces, self.machine, self.lengths, self.program, self.name)
        return sha256(dumped([parts, rest])).digest()


#: The request for the parts of one machine and one kind of stock, and their shares of it.
Lot = tuple[Request, tuple[Share, ...]]


def tasks_of(lot: Lot, stem: str, before: int) -> Iterator[ShareTask]:
    """The tasks of a lot, `before` others."""
    request, shares = lot
    machine, of = request.machine, len(shares)
    for number, share in enumerate(shares, 1):
        places = tuple(dict.fromkeys(share.pieces))
        at = {place: k for k, place in enumerate(places)}
        name = f"{stem}-{number}{machine.suffix}" if of > 1 else f"{stem}{machine.suffix}"
        yield ShareTask(
            before + number - 1, name, b"", tuple([request.parts[place] for place in places]),
            tuple([at[place] for place in share.pieces]), machine.name, share.lengths,
            (number, of),
        )  # fmt: skip


def stems_of(lots: Sequence[Lot]) -> list[str]:
    """What the programs of each lot are called: section or thickness, grade; and where two lots
    would be called the same, the machine."""
    plain = []
    for request, _ in lots:
        first, torch = request.parts[0], request.machine.torch
        what = first.profile.name or first.profile.code
        if torch is not None:
            own = first.profile.web_thickness
            what = f"PL{own if own is not None else torch.thickness or 0.0:g}"
        words = [what, first.grade] if first.grade else [what]
        stem = "_".join(cleaned(word.replace(" ", "")) or "_" for word in words)
        plain.append(free_of_devices(stem))
    twice = {stem for stem, count in Counter(map(folded, plain)).items() if count > 1}
    names = FileNames()
    return [
        names.take(f"{stem}_{cleaned(request.machine.name)}" if folded(stem) in twice else stem, "")
        for stem, (request, _) in zip(plain, lots, strict=True)
    ]
