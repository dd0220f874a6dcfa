"""The work of a batch over stock, as workers do it: files looked at, shares of stock posted."""

from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from hashlib import sha256

from msgspec import Struct
from msgspec.structs import replace

from beamcam.arguments import on_best_machine
from beamcam.batch.names import FileNames, cleaned, folded
from beamcam.batch.part_rows import part_row
from beamcam.batch.work import BatchSettings, Found, Task, parts_in, posted_of
from beamcam.errors import BeamcamError
from beamcam.files import REFUSED_SUFFIX
from beamcam.model.part import Part
from beamcam.model.part_json import part_to_json
from beamcam.model.plan import stock_used
from beamcam.model.request import Request, Share, number_of
from beamcam.pipeline import Begun, begin_share, plans_of
from beamcam.planning.manual_list import MARK_ROWS, manual_rows
from beamcam.reports.part_list import ManualWork, PartCount
from beamcam.reports.run import FileRow, PartRow, StockRow, as_message, dumped
from beamcam.system import free_of_devices


class FileState(Task, frozen=True):
    """One file to be looked at: which machine makes each of its parts."""

    def post(
        self, settings: BatchSettings, row: FileRow, work: Found
    ) -> Generator[str, None, None]:
        """Add each part with the first machine that makes it; those that none makes refuse."""
        parts = parts_in(self, settings, row)
        yield "read the file"
        for part in parts:
            count = PartCount(part, number_of(part, settings.quantity or "file"))
            request = replace(
                settings.request_of(part), quantity=1, stock=settings.lengths_for(part), remnants=()
            )
            try:
                (planned, *_), choice = on_best_machine(
                    request, settings.machines_for(part), plans_of
                )
            except BeamcamError as error:
                row["status"] = "refused"
                row["messages"] += map(as_message, error.diagnostics)
                work.looked.append(replace(count, refused=tuple(error.diagnostics)))
                continue
            row["messages"] += map(as_message, choice)
            kinds = [one["kind"] for one in manual_rows(planned.plan)]
            manual_work = ManualWork(sum(kind in MARK_ROWS for kind in kinds), kinds.count("bevel"))
            machine = planned.job.machine.name
            work.looked.append(replace(count, machine=machine, manual_work=manual_work))


class ShareTask(Task, frozen=True):
    """The pieces of one bar or sheet to be made; its name is that of the program."""

    parts: tuple[Part, ...]
    pieces: tuple[int, ...]  #: of each the place of its part
    machine: str
    lengths: tuple[float, ...]  #: of the bar
    program: tuple[int, int]  #: which one of its lot, and of how many

    def post(
        self, settings: BatchSettings, row: FileRow, work: Found
    ) -> Generator[str, None, None]:
        """Add the program."""
        planned = self.planned(settings)
        yield "planned"
        posted = yield from posted_of(planned, lambda: self.name + REFUSED_SUFFIX, row, work)
        if posted is None:
            return
        content = posted.text.encode("utf-8")
        work.outputs.append((self.name, content))
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
        made = part_row(posted, self.name, content, settings.timed)
        row_of_part: PartRow = {
            **made, "mark": named, "quantity": len(self.pieces), "length": length, "stock": stock,
        }  # fmt: skip
        row["parts"].append(row_of_part)

    def planned(self, settings: BatchSettings) -> Begun:
        """The program, planned. Raises PlanError."""
        request = replace(
            settings.request_of(self.parts[0]), parts=self.parts,
            machine=settings.machine_named(self.machine), quantity=settings.quantity or "file",
        )  # fmt: skip
        return begin_share(request, Share(self.pieces, self.lengths), program=self.program)

    @property
    def key(self) -> bytes:
        """A hash of all that its program depends on besides the shop."""
        parts = [part_to_json(part) for part in self.parts]
        rest = (self.pieces, self.machine, self.lengths, self.program, self.name)
        return sha256(dumped([parts, rest])).digest()


class Lot(Struct, frozen=True):
    """The parts of one machine and one kind of stock, and their shares of it."""

    request: Request
    shares: tuple[Share, ...]


def tasks_of(lot: Lot, stem: str, before: int) -> Iterator[ShareTask]:
    """The tasks of a lot, `before` others."""
    request, machine, of = lot.request, lot.request.machine, len(lot.shares)
    for number, share in enumerate(lot.shares, 1):
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
    plain = [_stem(lot) for lot in lots]
    twice = {stem for stem, count in Counter(map(folded, plain)).items() if count > 1}
    names = FileNames()
    return [
        names.take(
            f"{stem}_{cleaned(lot.request.machine.name)}" if folded(stem) in twice else stem, ""
        )
        for stem, lot in zip(plain, lots, strict=True)
    ]


def _stem(lot: Lot) -> str:
    first = lot.request.parts[0]
    what = first.profile.name or first.profile.code
    torch = lot.request.machine.torch
    if torch is not None:
        own = first.profile.web_thickness
        what = f"PL{own if own is not None else torch.thickness or 0.0:g}"
    words = [what, first.grade] if first.grade else [what]
    return free_of_devices("_".join(cleaned(word.replace(" ", "")) or "_" for word in words))
