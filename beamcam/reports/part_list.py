"""The part list and the cutting list of a shop, as rows."""

from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import suppress
from math import pi, radians, tan

from msgspec import Struct
from msgspec.structs import astuple, replace

from beamcam.errors import BeamcamError, Diagnostic, errors_in
from beamcam.geometry.plane import Box
from beamcam.model.part import PLATE_FACES, Contour, EndPlane, Hole, Part, Slot
from beamcam.model.plan import AnyPlan
from beamcam.model.section import (
    STEEL_KG_MM3,
    measures_of,
    plate_area,
    section_area,
    single_contours,
    weight_of,
)
from beamcam.planning.manual_list import MARK_ROWS, manual_rows
from beamcam.reports.tables import Cell, Table

# --- weights: finished, gross, by the catalogue and by a file's header ----------------------------

# Finished is what the crane lifts: holes, slots and cut-outs are taken off. Where holes and slots
# are all that a bar has that takes their areas by the thickness of their wall; of skew ends and
# copes, whose walls overlap, the solid says it. Gross is what is bought.


DIFFERS = 0.05  #: share by which a weight of the catalogue or the header that is shown differs
#: Sections whose holes go through more than the wall of their face.
ROUND = ("RO", "RU")


class Weights(Struct, frozen=True):
    """Kilograms of one piece; None where it is not known."""

    finished: float | None
    gross: float | None  #: the section over the whole length; of a plate within its outline
    catalogue: float | None = None  #: by the section's name, where it is another
    header: float | None = None  #: by the figure in its file, where it is another


def weights_of(part: Part) -> Weights:
    """The weights of one piece, those of catalogue and header where they differ by over 5 %."""
    gross = weight_of(part)
    if gross is None:
        return Weights(None, None)
    known = measures_of(part.profile.name)
    catalogue = header = None
    if known is not None and part.profile.code == known[0]:
        h, b, flange, web, radius = known[1]
        standard = replace(
            part.profile, height=h, width=b, flange_thickness=flange, web_thickness=web,
            radius=radius,
        )  # fmt: skip
        area = section_area(standard)
        catalogue = None if area is None else area * part.length * STEEL_KG_MM3
    if part.weight > 0:
        # DSTV NC: kg/m of a bar, kg/m2 of a plate
        is_plate = part.profile.code == "B"
        header = part.weight * (plate_area(part) / 1e6 if is_plate else part.length / 1000)
    return Weights(_finished(part, gross), gross, _other(catalogue, gross), _other(header, gross))


def _other(weight: float | None, gross: float) -> float | None:
    """A weight that differs from the gross one; None for one that does not."""
    return weight if weight is not None and abs(weight - gross) > DIFFERS * gross else None


def _finished(part: Part, gross: float) -> float:
    """The gross weight less what the features take.

    Without manifold3d, or where no solid is known, only what holes and slots take is off.
    """
    alone = [f for f in part.features if isinstance(f, Hole | Slot)]
    left = gross / STEEL_KG_MM3
    if _needs_solid(part):
        from beamcam.solid.kernel import outline
        from beamcam.solid.part_solid import part_solid

        with suppress(BeamcamError):  # a section or a face without figures, or no kernel
            clear = _clear_of_cuts(part, alone)
            others = tuple(f for f in part.features if f not in clear)
            solid = float(part_solid(replace(part, features=others)).volume())
            if part.profile.code == "C":  # whose solid has no lips, and whose gross weight has
                solid += left - outline(part).area * part.length
            left, alone = solid, clear
    return (left - sum(_taken(f, part) for f in alone)) * STEEL_KG_MM3


def _clear_of_cuts(part: Part, holes: Sequence[Hole | Slot]) -> list[Hole | Slot]:
    """Those that no cut comes near: what they take is known without a solid, which takes longer."""
    if part.profile.code in (*ROUND, "C") or any(isinstance(f, EndPlane) for f in part.features):
        return []
    ends = astuple(part.cuts)
    lean = max(abs(tan(radians(end))) for end in ends) * (part.profile.height + part.profile.width)
    places = Counter((round(hole.x, 2), round(hole.y, 2)) for hole in holes)
    edges: list[tuple[bool, Box]] = []  #: boxes of cuts, wider by their bevels
    for contour in part.contours:
        if contour.process == "cut":
            steep = max((min(abs(bevel.angle), 80.0) for bevel in contour.bevels), default=0.0)
            wide = part.profile.thickness(contour.face) * tan(radians(steep))
            boxes = (curve.bbox for curve in contour.curves)
            edges += [
                (contour.face in PLATE_FACES, (x0 - wide, y0 - wide, x1 + wide, y1 + wide))
                for x0, y0, x1, y1 in boxes
            ]

    def is_clear(hole: Hole | Slot) -> bool:
        r = hole.diameter / 2
        if isinstance(hole, Slot):
            r += hole.length + hole.height
        near = any(
            on_web == (hole.face in PLATE_FACES)
            and x0 - r < hole.x < x1 + r and y0 - r < hole.y < y1 + r
            for on_web, (x0, y0, x1, y1) in edges
        )  # fmt: skip
        is_alone = places[round(hole.x, 2), round(hole.y, 2)] == 1
        return is_alone and not near and lean + r < hole.x < part.length - lean - r

    return [hole for hole in holes if is_clear(hole)]


def _needs_solid(part: Part) -> bool:
    """Whether more than holes and slots, each alone in its wall, takes of the gross weight."""
    cuts = [f for f in part.features if isinstance(f, Contour) and f.process == "cut"]
    holes = [f for f in part.features if isinstance(f, Hole | Slot) and f.kind != "mark"]
    # Two at one place: a countersink and its hole, or a hole that came twice.
    nested = len({(round(hole.x, 2), round(hole.y, 2)) for hole in holes}) < len(holes)
    if any(isinstance(f, EndPlane) for f in part.features) or nested:
        return True
    angles = part.cuts
    skew = any((angles.web_start, angles.web_end, angles.flange_start, angles.flange_end))
    if part.profile.code == "B":  # whose outline is its gross weight
        on_edge = any(hole.face not in ("v", "h") for hole in holes)
        outlines = {c.face for c in single_contours(part) if c.kind == "outer"}
        return on_edge or skew or len(outlines) > 1 or any(c.bevels for c in cuts)
    return bool(cuts) or skew or (part.profile.code in ROUND and bool(holes))


def _taken(feature: Hole | Slot, part: Part) -> float:
    """mm3 that a hole or a slot takes of the wall of its face; of a centre point nothing."""
    wall = part.profile.thickness(feature.face)
    depth = wall if feature.depth is None else min(feature.depth, wall)
    round_area = pi * feature.diameter**2 / 4
    if isinstance(feature, Slot):
        beside = (feature.length + feature.height) * feature.diameter
        return (round_area + beside + feature.length * feature.height) * depth
    return 0.0 if feature.kind == "mark" else round_area * depth


PARTS = (
    "mark", "profile", "length", "quantity", "grade", "weight_kg", "total_kg", "gross_kg",
    "catalogue_kg", "header_kg", "holes", "slots", "contours", "marks", "marks_by_hand",
    "bevels_by_hand", "order", "drawing", "phase", "machine", "file", "not_made",
)  # fmt: skip
BARS = (
    "bar", "profile", "grade", "machine", "stock", "pieces", "parts", "cuts", "remnant",
    "used_percent",
)  # fmt: skip
CUTS = ("bar", "piece", "mark", "profile", "grade", "length", "start", "turn", "file")


class PartCount(Struct, frozen=True):
    """A part and how often it is wanted, and by what it is made."""

    part: Part
    quantity: int
    machine: str = ""  #: the first that makes it; "" for none
    manual_work: "ManualWork | None" = None  #: None where no machine makes the part
    refused: tuple[Diagnostic, ...] = ()  #: why it is not made


class ManualWork(Struct, frozen=True):
    """The manual work on one piece that a machine's program leaves."""

    marks: int
    bevels: int


def manual_work_of(plan: AnyPlan) -> ManualWork:
    """What the program of a plan leaves."""
    kinds = [row["kind"] for row in manual_rows(plan)]
    return ManualWork(sum(kind in MARK_ROWS for kind in kinds), kinds.count("bevel"))


class CutPiece(Struct, frozen=True):
    """A piece on a bar."""

    part: Part  #: as it was read
    start: float  #: x of its x 0 on the bar, mm
    turn: str  #: how it lies


class CutBar(Struct, frozen=True):
    """A bar of stock: its pieces with their places along it, and what is left."""

    pieces: tuple[CutPiece, ...]
    length: float
    cuts: float  #: mm of kerfs and trims
    remnant: float
    machine: str


def part_list(part_counts: Iterable[PartCount]) -> Table:
    """A row for each part; what is not known is empty. Those that are not made are marked."""
    counts = tuple(part_counts)
    rows = tuple(_part_row(one) for one in counts)
    decimals = (None, None, 3, None, None, 3, 3, 3, 3, 3, *(None,) * 12)
    marked = frozenset(k for k, one in enumerate(counts) if one.refused)
    return Table("part list", PARTS, rows, decimals, marked)


def _part_row(one: PartCount) -> tuple[Cell, ...]:
    part, quantity, manual_work = one.part, one.quantity, one.manual_work
    weights = weights_of(part)
    weight = weights.finished
    lines = [c for c in part.contours if c.process != "cut"]
    points = [hole for hole in part.holes if hole.kind == "mark"]
    why = next(
        (f"{diagnostic.code}: {diagnostic.message}" for diagnostic in errors_in(one.refused)), None
    )
    return (
        part.mark, part.profile.name, part.length, quantity, part.grade, weight,
        None if weight is None else weight * quantity, weights.gross, weights.catalogue,
        weights.header, len(list(part.holes)) - len(points),
        len(list(part.slots)), len(list(part.contours)) - len(lines),
        len(lines) + len(points) + len(list(part.texts)),
        *((None, None) if manual_work is None else (manual_work.marks, manual_work.bevels)),
        part.order, part.drawing, part.phase, one.machine or None, part.source.file, why,
    )  # fmt: skip


def total_row(table: Table) -> tuple[Cell, ...]:
    """Pieces and kilograms of a part list, under its columns."""
    quantity, total = table.head.index("quantity"), table.head.index("total_kg")
    cells: list[Cell] = [None] * len(table.head)
    cells[0] = "total"
    cells[quantity] = sum(int(row[quantity] or 0) for row in table.rows)
    cells[total] = float(sum(row[total] or 0.0 for row in table.rows))  # type: ignore[misc]
    return tuple(cells)


def bar_list(bars: Sequence[CutBar]) -> Table:
    """A row for each bar, with its account: pieces, kerfs and trims, and remnant, all in mm."""
    rows = tuple(
        (number, bar.pieces[0].part.profile.name, bar.pieces[0].part.grade, bar.machine,
         bar.length, len(bar.pieces), _steel(bar), bar.cuts,
         bar.remnant, 100 * _steel(bar) / bar.length)
        for number, bar in enumerate(bars, 1)
    )  # fmt: skip
    return Table("bars", BARS, rows, (None, None, None, None, 3, None, 3, 3, 3, 1))


def _steel(bar: CutBar) -> float:
    """mm of the bar that are parts."""
    return sum(piece.part.length for piece in bar.pieces)


def cutting_list(bars: Sequence[CutBar]) -> Table:
    """A row for each piece, bar by bar, with its place along the bar and how it lies."""
    rows = tuple(
        (number, place, piece.part.mark, piece.part.profile.name, piece.part.grade,
         piece.part.length, piece.start, piece.turn, piece.part.source.file)
        for number, bar in enumerate(bars, 1)
        for place, piece in enumerate(bar.pieces, 1)
    )  # fmt: skip
    return Table("cutting list", CUTS, rows, (None, None, None, None, None, 3, 3, None, None))
