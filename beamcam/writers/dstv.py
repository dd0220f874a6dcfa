"""The writer of DSTV files, by the book: 24 header lines, holes in BO, numbers in columns."""

import re

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import BeamcamError, Source
from beamcam.model.anchors import plane_positions
from beamcam.model.part import (
    FACES,
    Bend,
    Camber,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Part,
    Plane,
    Slot,
    TextMark,
)
from beamcam.writers import dstv_rows
from beamcam.writers.dstv_rows import format_number, numbers

_CONTOUR_CODES = {
    ("outer", "cut"): "AK", ("inner", "cut"): "IK", ("open", "punch"): "KO",
    ("inner", "punch"): "KO", ("open", "powder"): "PU", ("inner", "powder"): "PU",
}  # fmt: skip
#: What stands before the rows of features that are there, so that no reader has them made again.
MADE = "**BEAMCAM MADE "
MADE_ENDS = "ENDS"
_TEXT_LINES = 4  #: free texts at the end of the header


def write(part: Part, tolerance: float | None = None) -> str:
    """The part as DSTV text, lines ended by a line feed; reading it gives the same part.

    Numbers are rounded to 6 decimals. Curves that DSTV does not have are refused, or written as
    polylines no further than `tolerance` (mm) from them. Arcs beyond 180 degrees become several.
    Features that are there already stand in comments.
    Layers, colours and a GlobalId have no place in the format and are left out.
    Raises BeamcamError for what the format cannot hold.
    """
    sheet = _Sheet(part)
    sheet.comments_at("start")
    sheet.lines.append("ST")
    for i, text in enumerate(_header(part), 1):
        sheet.comments_at(f"header:{i}")
        sheet.lines.append("  " + text if text else "  ")
    for i, point in enumerate(part.section):
        row = f"  {point.side}{numbers(point.y, point.z, point.radius)}"
        sheet.row("PR", f"section:{i}", row)
    if part.tolerance is not None:
        least, greatest = part.tolerance
        sheet.row("TO", "tolerance", f"  {format_number(least)} {format_number(greatest)}")
    _write_features(part, sheet, tolerance)
    for i, (word, text) in enumerate(part.info):
        sheet.row("IN", f"info:{i}", _info_row(word, text, part.source))
    sheet.comments_at("end")
    if part.made is not None:
        there = _Sheet(replace(part, features=part.made, comments=()))
        _write_features(there.part, there, tolerance)
        sheet.lines += [MADE + line for line in (MADE_ENDS, *there.lines)]
    sheet.lines.append("EN")
    sheet.comments_at("after-end")
    for place in sheet.comments:  # without a place
        raise BeamcamError(dstv_rows.WRITE_COMMENT.at(part.source, found=place))
    return "\n".join(sheet.lines) + "\n"


class _Sheet(Struct):
    """The lines written so far, the block that they are in and the comments still to come."""

    part: Part
    lines: list[str] = field(default_factory=list)
    block: object = None  #: what the rows of the open block have in common
    comments: dict[str, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for comment in self.part.comments:
            _check_text(comment.text, "a comment", self.part.source, comment=True)
            self.comments.setdefault(comment.before, []).append(comment.text)

    def comments_at(self, anchor: str) -> None:
        self.lines += ["**" + text for text in self.comments.pop(anchor, ())]

    def row(self, code: str, anchor: str, row: str, same: object = "") -> None:
        """One row in a block of `code`, a new one where `same` differs from the row before."""
        self.open(code, anchor, (code, same))
        self.comments_at(anchor)
        self.lines.append(row)

    def open(self, code: str, anchor: str, block: object) -> None:
        """Begin a block unless the open one goes on; a comment before its code needs a new one."""
        if block != self.block or f"block:{anchor}" in self.comments:
            self.comments_at(f"block:{anchor}")
            self.lines.append(code)
            self.block = block

    def rows(self, code: str, anchor: str, rows: list[str]) -> None:
        """A block of its own, with comments between its rows."""
        self.open(code, anchor, (code, anchor))
        for i, row in enumerate(rows):
            self.comments_at(f"{anchor}:{i}" if i else anchor)
            self.lines.append(row)


def _header(part: Part) -> list[str]:
    """The header's lines, 24 or more."""
    profile, cuts, source = part.profile, part.cuts, part.source
    for name in ("order", "drawing", "phase", "mark", "grade"):
        _check_text(getattr(part, name), f"the {name}", source)
    _check_text(profile.name, "the profile", source)
    for text in part.notes:
        _check_text(text, "a text of the header", source)
    length = f"{format_number(part.length):>11}"
    if part.saw_length is not None:
        length += "," + format_number(part.saw_length)
    sizes = (
        profile.height, profile.width, profile.flange_thickness, profile.web_thickness or 0.0,
        profile.radius,
    )  # fmt: skip
    angles = (cuts.web_start, cuts.web_end, cuts.flange_start, cuts.flange_end)
    notes = [*part.notes, *[""] * (_TEXT_LINES - len(part.notes))]
    return [
        part.order or "-", part.drawing or "-", part.phase or "-", part.mark, part.grade or "-",
        str(part.quantity), profile.name, profile.code, length,
        *(f"{format_number(size):>11}" for size in sizes),
        *(f"{format_number(value, 3):>11}" for value in (part.weight, part.surface, *angles)),
        *notes,
    ]  # fmt: skip


def _write_features(part: Part, sheet: _Sheet, tolerance: float | None) -> None:
    """Planes and features, each plane as early as its number is free."""
    positions = plane_positions(part.planes, part.features)
    pending = list(zip(positions, range(len(part.planes)), part.planes, strict=True))
    valid: dict[str, str] = {}  # by number, the plane that it names now

    def write_planes(before: int) -> None:
        while pending and pending[0][0] <= before:
            _, k, plane = pending.pop(0)
            number = plane.name.split("#")[0]
            if not re.fullmatch("E[0-9]", number):
                fault = dstv_rows.WRITE_FACE.at(plane.source, found=plane.name, what="a plane")
                raise BeamcamError(fault)
            valid[number] = plane.name
            points = (plane.origin, plane.along_x, plane.along_y)
            sheet.rows(number, f"plane:{k}", [" " + numbers(*point) for point in points])

    for i, feature in enumerate(part.features):
        write_planes(i)
        _write_feature(feature, f"feature:{i}", sheet, valid, tolerance)
    write_planes(len(part.features))


def _write_feature(
    feature: Feature, anchor: str, sheet: _Sheet, valid: dict[str, str], tolerance: float | None
) -> None:
    # Rows of a block share the face, and whether they have a reference letter: a row without one
    # would inherit that of the row before.
    source, planes = feature.source, sheet.part.planes
    match feature:
        case Hole() | Slot():
            code = _code("BO", feature.face, "a hole", planes, valid, source)
            if isinstance(feature, Hole):
                row = dstv_rows.hole_row(feature)
            else:
                row = dstv_rows.slot_row(feature)
            sheet.row(code, anchor, row, (feature.face, bool(feature.edge)))
        case TextMark():
            code = _code("SI", feature.face, "a text", planes, valid, source)
            _check_text(feature.text, "a text mark", source, empty=False)
            row = dstv_rows.text_row(feature)
            sheet.row(code, anchor, row, (feature.face, bool(feature.edge)))
        case Contour():
            code = _CONTOUR_CODES.get((feature.kind, feature.process), "")
            if not code:
                kind, process = feature.kind, feature.process
                raise BeamcamError(dstv_rows.WRITE_CONTOUR.at(source, kind=kind, process=process))
            code = _code(code, feature.face, "a contour", planes, valid, source)
            sheet.rows(code, anchor, dstv_rows.contour_rows(feature, tolerance))
        case Bend():
            radius = () if feature.radius is None else (feature.radius,)
            bend = (*feature.start, *feature.end, feature.angle, *radius)
            sheet.row("KA", anchor, " " + numbers(*bend))
        case EndPlane():
            sheet.row("SC", anchor, " " + numbers(*feature.point, *feature.normal))
        case Camber():
            _code("UE", feature.face, "a camber", (), {}, source)
            row = dstv_rows.place(feature.face, feature.x, "", format_number(feature.y))
            sheet.row("UE", anchor, row, feature.face)


def _code(
    code: str,
    face: str,
    what: str,
    planes: tuple[Plane, ...],
    valid: dict[str, str],
    source: Source,
) -> str:
    """The block code for a feature on `face`; that of a plane takes its number."""
    if face in FACES:
        return code
    number = face.split("#")[0]
    if face not in {plane.name for plane in planes}:
        raise BeamcamError(dstv_rows.WRITE_FACE.at(source, found=face, what=what))
    if valid.get(number) != face:
        raise BeamcamError(dstv_rows.WRITE_PLANE.at(source, found=face))
    return code[0] + number[1]


def _info_row(word: str, text: str, source: Source) -> str:
    """A line of IN; one without a word may hold no colon, which would make it one."""
    place = "a line of information"
    _check_text(word + text, place, source)
    row = f"{word} : {text}" if word else text
    if (":" in word) or (not word and (":" in text or len(text) <= 2)):
        expected = "a word and a text, or a text of 3 characters or more without a colon"
        raise BeamcamError(
            dstv_rows.WRITE_TEXT.at(source, found=row, place=place, expected=expected)
        )
    return "  " + row.rstrip()


def _check_text(
    text: str, place: str, source: Source, empty: bool = True, comment: bool = False
) -> None:
    """Refuse a text that would not come back from a line of its own."""
    expected = ""
    if any(ord(letter) < 32 or ord(letter) == 127 for letter in text.replace("\t", " ")):
        expected = "one line without control characters"
    elif not comment and text.startswith("**"):
        expected = "no two stars first, which begin a comment"
    elif not empty and not text.strip():
        expected = "a text that is not empty"
    if expected:
        fault = dstv_rows.WRITE_TEXT.at(source, found=text, place=place, expected=expected)
        raise BeamcamError(fault)
