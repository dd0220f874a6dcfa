"""The header, block ST: 20 to 24 lines that count by their position."""

import re
from collections.abc import Iterator
from math import pi

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.errors import Rule, Source
from beamcam.geometry.plane import join_boxes
from beamcam.model.part import (
    ALONG_DEG,
    PROFILE_CODES,
    Contour,
    EndCuts,
    Part,
    Profile,
    ProfileCode,
)
from beamcam.model.section import (
    LIP_SHARES,
    STEEL_KG_MM3,
    TOLERANCE,
    difference,
    measures_of,
    plain_name,
    section_fault,
)
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.blocks import CODES, PLAIN_CODES, Log, number

MIN_LINES, MOST_LINES = 20, 24
TEXT_LIMIT = 80  # DSTV NC, page 6

#: Data behind the header whose block code is missing: a face and a number, or a number.
_ROW = re.compile(r"([vouh]\s*)?[+-]?[0-9]+\.[0-9]")

#: A name with four figures, as writers call lipped channels: C200*70*20*2, LIP C 100 x 50 x 20 x 2.
_FOUR = re.compile(r"[A-Z -]*" + r"\s*[-X*×/]\s*".join([r"(\d+(?:[.,]\d+)?)"] * 4), re.IGNORECASE)

_CODES: dict[str, ProfileCode] = {code: code for code in PROFILE_CODES}

_WHOLE = re.compile(r"([0-9]{1,9})(\.0*)?", re.ASCII)  #: a quantity, which some write as 2.00

#: Names of the header lines that are numbers, 10 to 20.
NUMBER_NAMES = (
    "height", "flange width", "flange thickness", "web thickness", "radius", "weight", "surface",
    "web start cut", "web end cut", "flange start cut", "flange end cut",
)  # fmt: skip

LIMITS = (" of at least 0", f" between -{ALONG_DEG:g} and {ALONG_DEG:g}")  #: of sizes, of angles


class HeaderLines(Struct):
    """The header as text: its values by position, their lines, and its comments."""

    values: list[str]
    numbers: list[int]
    comments: list[tuple[int, str]]  #: position of the value that the comment precedes, text
    trailing: list[tuple[int, str]]  #: comments behind the last line that a header can have: line
    end: int  #: index of the line behind the header


def header_lines(lines: list[str], texts: list[str], start: int) -> HeaderLines:
    """The header that begins at index `start`, behind the line ST.

    `texts` are the lines without the blanks around them.
    The first 20 lines are taken as they come, since a piece mark may be `B1` or `SI`. After them
    a block code ends the header, if it stands as far in as ST itself does.
    """
    indent = _indent(lines[start - 1])
    comments: list[tuple[int, str]] = []
    trailing: list[tuple[int, str]] = []
    values: list[str] = []
    numbers: list[int] = []
    for index, text in enumerate(texts[start:], start):
        if text[:2] == "**":
            if len(values) < MOST_LINES:
                comments.append((len(values) + 1, text[2:]))
            else:
                trailing.append((index + 1, text[2:]))
            continue
        if (count := len(values)) >= MIN_LINES:
            if count >= MOST_LINES:
                if not text:
                    continue
                # the texts stand further in than ST: a line that does not is none of them
                outside = _indent(lines[index]) <= indent < _indent(lines[numbers[8] - 1])
                if _ROW.match(text) or outside:
                    break
            if len(text) == 2 and _is_code(text, lines, index, indent, count):
                break
        values.append(text)
        numbers.append(index + 1)
    else:
        index = len(lines)
    return HeaderLines(values, numbers, comments, trailing, index)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _is_code(text: str, lines: list[str], index: int, indent: int, count: int) -> bool:
    """Whether a line of two characters behind header line 20 is a block code and no text."""
    if _indent(lines[index]) != indent:
        return False
    if count >= MOST_LINES:
        return text in CODES or (text.isupper() and text.isalpha())
    if text in PLAIN_CODES:
        return True
    # "E1" may be a text: as a plane it is followed by numbers. B1 and the like follow a plane.
    follower = lines[index + 1].split() if index + 1 < len(lines) else []
    return text in CODES and text[0] == "E" and len(follower) in (3, 6, 9)


def read_header(head: HeaderLines, source: Source, log: Log) -> Part | None:
    """The part as its header has it; None, with errors in the log, if that cannot be read."""
    if _is_short(head, log):
        return None
    values, lines = head.values, head.numbers
    before = len(log.diagnostics)
    whole = _WHOLE.fullmatch(values[5])
    quantity = int(whole[1]) if whole else None
    if whole is None:
        log.add(rules.QUANTITY, lines[5], found=values[5])
    elif quantity == 0 or whole[2]:
        log.add(rules.QUANTITY_FORM, lines[5], found=values[5], value=quantity)
    code = _CODES.get(values[7].upper())
    if code is None:
        log.add(rules.PROFILE_CODE, lines[7], found=values[7])
    elif code != values[7]:
        log.add(rules.PROFILE_CASE, lines[7], found=values[7], code=code)
    length, saw_length = _lengths(values[8], "," in values[9], lines[8], log)
    dimensions = _dimensions(values, lines, log)
    if quantity is None or code is None or length is None or dimensions is None:
        return None
    height, width, flange, web, radius, weight, surface, *cuts = dimensions
    profile, fault, differences = _section(code, values[6], height, width, flange, web, radius)
    for rule, said in differences:
        log.add(rule, lines[9], **said)
    if height <= 0:
        log.add(rules.HEIGHT, lines[9], found=height)
    elif fault is not None:
        log.add(rules.SECTION, lines[9], found=fault, code=code)
    elif code == "M" and (corner := corner_by_weight(profile, weight)):
        log.add(rules.CORNER_WEIGHT, lines[13], found=radius, radius=corner, weight=weight)
        profile = replace(profile, radius=corner)
    elif code == "C" and profile.lip is None and _FOUR.fullmatch(profile.name):
        sizes = f"{height:g} x {width:g}, {flange:g} thick"
        log.add(rules.LIP_NAME, lines[6], found=profile.name, sizes=sizes)
    elif code == "U":
        lip = lip_by_name(replace(profile, code="C")) or 0.0
        if lip and lip >= LIP_SHARES[0] * width:
            log.add(rules.LIP_CODE, lines[7], found=code, name=profile.name, lip=lip)
    _warn_of_texts(values, lines, log)
    known_lines = {d.source.line for d in log.diagnostics[before:]}
    log.taken += [line for line in lines if line not in known_lines] if known_lines else lines
    texts = ["" if value == "-" else value for value in values]  # a dash means none
    while len(texts) > MIN_LINES and not texts[-1]:
        texts.pop()
    return Part(
        mark=values[3], profile=profile, length=length, source=source, quantity=quantity,
        saw_length=saw_length, order=texts[0], drawing=texts[1], phase=texts[2], grade=texts[4],
        cuts=EndCuts(*cuts), weight=weight, surface=surface, notes=tuple(texts[MIN_LINES:]),
        cut_lines=(lines[16], lines[17], lines[18], lines[19]),
    )  # fmt: skip


def _is_short(head: HeaderLines, log: Log) -> bool:
    """Whether lines are missing: at the end, or where a code stands in place of a number."""
    values, lines = head.values, head.numbers
    if len(values) < MIN_LINES:
        last = lines[-1] if lines else head.end
        log.add(rules.HEADER_SHORT, last, found="the end of the file", count=len(values))
        return True
    for i in range(8, MIN_LINES):
        if values[i] in CODES:
            log.add(rules.HEADER_SHORT, lines[i], found=values[i], count=i)
            return True
    return False


#: Sections of ASTM A6 and A500 by code, named by their height in inches, and the greatest of it.
_INCHES = {
    "I": (re.compile(r"(?:W|S|M|HP)(\d+)X[\d.]+"), 44), "U": (re.compile(r"M?C(\d+)X[\d.]+"), 18),
    "T": (re.compile(r"[WMS]T(\d+)X[\d.]+"), 22), "M": (re.compile(r"HSS(\d+)X.+/\d+"), 34),
    "L": (re.compile(r"L(\d+)X.+/\d+"), 12),
}  # fmt: skip


def _differences(profile: Profile) -> Iterator[tuple[Rule, dict[str, object]]]:
    """What to say of a section that is known by its name and has another size in the header."""
    named, most = _INCHES.get(profile.code, (None, 0))
    match = named.fullmatch(plain_name(profile.name)) if named else None
    if match and int(match[1]) <= most and 0.0 < profile.height <= 1.5 * int(match[1]):
        yield rules.INCHES, {"height": profile.height, "name": profile.name}
    code, sizes = measures_of(profile.name) or ("", None)
    given = (profile.height, profile.width, profile.flange_thickness, profile.web_thickness or 0.0)
    if sizes is None or code != profile.code or min(given) <= 0.0:
        return
    turned = replace(profile, height=profile.width, width=profile.height)
    ways = (profile, turned) if code in ("L", "M") else (profile,)
    if min(difference(way, sizes) for way in ways) > MOST_OFF:
        found, expected = (" x ".join(f"{size:g}" for size in one) for one in (given, sizes[:4]))
        yield rules.NAME_SIZES, {"sizes": found, "name": profile.name, "expected": expected}


@cached("dstv.sections")
def _section(
    code: ProfileCode, name: str, height: float, width: float, flange: float, web: float,
    radius: float,
) -> tuple[Profile, str | None, tuple[tuple[Rule, dict[str, object]], ...]]:  # fmt: skip
    """A section, the same object for all files that have it, what is impossible in it, and how
    it differs from its name."""
    sizes = (size + 0.0 for size in (height, width, flange, web, radius))  # no -0
    profile = Profile(code, name, *sizes)
    if code == "C":
        profile = replace(profile, lip=lip_by_name(profile))
    fault = section_fault(profile) if min(width, flange, web) > 0 else None
    return profile, fault, tuple(_differences(profile))


def lip_by_name(profile: Profile) -> float | None:
    """The length of the lips of a C, which its name says where no header does; else None.

    Of four figures three have to be the header's height, width and thickness, in whatever order
    writers have them; the other one is the lip.
    """
    match = _FOUR.fullmatch(profile.name)
    if match is None:
        return None
    figures = [float(text.replace(",", ".")) for text in match.groups()]
    known = sorted((profile.height, profile.width, profile.flange_thickness))
    lips = set()
    for k, figure in enumerate(figures):
        others = sorted(figures[:k] + figures[k + 1 :])
        if all(abs(a - b) <= TOLERANCE for a, b in zip(others, known, strict=True)):
            lips.add(figure)
    lip = lips.pop() if len(lips) == 1 else None
    return lip if lip and section_fault(replace(profile, lip=lip)) is None else None


MOST_OFF = 0.5  #: mm that the sizes of a header may be off those of the section by its name
MOST_CORNER = 3.5  #: walls that a corner is round at most; 3 by EN 10219-2, annex B


def corner_by_weight(profile: Profile, weight: float) -> float | None:
    """The outer radius of the corners of a rectangular tube that its weight (kg/m) has, mm.

    Round corners lack (4 - pi) (R2 - (R - t)2) of the area that sharp ones have. None where the
    header has a radius that can be, or the weight none: catalogues give it to a third place.
    """
    wall = profile.web_thickness or 0.0
    if weight <= 0.0 or not 0.0 < wall == profile.flange_thickness > profile.radius:
        return None
    height, width = profile.height, profile.width
    sharp = height * width - (height - 2 * wall) * (width - 2 * wall)
    lacking = (sharp - weight / 1000 / STEEL_KG_MM3) / (4 - pi)
    radius = round((lacking / wall + wall) / 2, 1)
    return radius if wall <= radius <= min(MOST_CORNER * wall, height / 2, width / 2) else None


def _warn_of_texts(values: list[str], lines: list[int], log: Log) -> None:
    """Warn of texts longer or more than the standard has, and of a file not named by its mark."""
    for value, line in zip(values, lines, strict=True):
        if len(value) > TEXT_LIMIT:
            log.add(rules.TEXT_LONG, line, count=len(value), limit=TEXT_LIMIT)
    for i in range(MOST_LINES, len(values)):
        log.add(rules.HEADER_EXTRA, lines[i], found=values[i], number=i + 1)
    for field, name in (("drawing", values[1]), ("phase", values[2])):
        if len(name) > 1 and name != values[3] and name in log.file:
            stem = log.file.replace("\\", "/").rpartition("/")[2].rsplit(".", 1)[0]
            if stem == name:
                log.add(rules.MARK_ELSEWHERE, lines[3], found=values[3], field=field, name=name)


def _lengths(text: str, commas: bool, line: int, log: Log) -> tuple[float | None, float | None]:
    """Length and saw length; `commas`: the lines after this one have decimal commas."""
    # "500.40,500.40"   length, saw length
    fields = [text] if commas and text.count(",") == 1 and "." not in text else text.split(",")
    values = [number(part.strip(), line, log) for part in fields]
    length = values[0]
    if len(values) > 2 or length is None or None in values or length <= 0:
        log.add(rules.LENGTH, line, found=text)
        return None, None
    saw = values[1] if len(values) == 2 else None
    if saw is not None and saw < length - 0.2:
        log.add(rules.SAW_LENGTH, line, saw=saw, length=length)
    return length, saw


def _dimensions(values: list[str], lines: list[int], log: Log) -> list[float] | None:
    """Header lines 10 to 20 as numbers; None if one that matters cannot be read."""
    result: list[float] = []
    failed = False
    rows = zip(NUMBER_NAMES, values[9:MIN_LINES], lines[9:MIN_LINES], strict=True)
    for i, (name, text, line) in enumerate(rows):
        value = number(text, line, log) if text else 0.0
        if not text:
            log.add(rules.HEADER_BLANK, line, number=i + 10, name=name)
        elif value is None and i in (5, 6):
            log.add(rules.WEIGHT, line, number=i + 10, name=name, found=text)
        elif value is None or (i < 5 and value < 0) or (i > 6 and abs(value) >= ALONG_DEG):
            limits = LIMITS[0 if i < 5 else 1]
            log.add(rules.HEADER_NUMBER, line, number=i + 10, name=name, found=text, limits=limits)
            failed = True
        result.append(0.0 if value is None else value)
    return None if failed else result


# --- tees -----------------------------------------------------------------------------------------

# T sections whose header stands on end: the stem's height in line 10, the flange's width in 11.
#
# DSTV, 7th edition, page 7: the flange of a T lies along Y, so that line 10, the height, is how
# wide it is, and its stem stands along Z, so that line 11 is how high that is.


DRAWN = 1.0  #: mm between an outline and its figure in the header
HALF = 3.0  #: mm between half a beam and a T: its cut takes some
NOMINAL = 0.1  #: share that the stem of a WT is off its name
INCHES = 50.0  #: nominal heights of fewer are inches: WT22 is the highest, WT100 the lowest in mm
_WT = re.compile(r"\s*(?:WT|MT|ST)\s*([0-9]+(?:\.[0-9]+)?)\s*[xX*]")
_HALVED = re.compile(r"\s*(?:1/2\s*|½\s*)(\S.*?)\s*|\s*(\S.*?)\s*/\s*2\s*")


def upright(data: bytes, part: Part, header: list[int], log: Log) -> bytes | None:
    """A file whose header has the sizes of its T as the outlines are, where they stand on end.

    None of any other file. Where no outline shows it but the name does, that is told, and the
    header counts. `header` are the lines of its values.
    """
    profile = part.profile
    high, wide = profile.height, profile.width
    if profile.code != "T" or abs(high - wide) <= DRAWN:
        return None
    values = {"name": profile.name, "height": high, "width": wide}
    flange, stem = _drawn(part, "v"), _drawn(part, "ou")
    fits = [(size, *pair) for size, *pair in ((flange, high, wide), (stem, wide, high)) if size]
    size, right, wrong = fits[0] if fits else (high, high, wide)
    rows = data.splitlines(keepends=True)
    if abs(size - wrong) <= DRAWN and abs(size - wrong) < abs(size - right):
        log.add(rules.TEE_OUTLINE, header[9], **values)
        for k in (9, 11):  # height and width, thicknesses of flange and web
            a, b = header[k] - 1, header[k + 1] - 1
            rows[a], rows[b] = rows[b], rows[a]
        return b"".join(rows)
    if not fits and _named_on_end(profile):
        log.add(rules.TEE_NAME, header[9], **values)
    return None


def _drawn(part: Part, faces: str) -> float:
    """How far the outlines on some faces reach across; 0 without any."""
    boxes = [
        curve.bbox
        for c in part.features if isinstance(c, Contour) and c.kind == "outer" and c.face in faces
        for curve in c.curves
    ]  # fmt: skip
    box = join_boxes(boxes)
    return 0.0 if box is None else box[3]


def _named_on_end(profile: Profile) -> bool:
    """Whether the name has a stem as high as line 10, and not as line 11."""
    if match := _WT.match(profile.name):
        nominal = float(match[1]) * (25.4 if float(match[1]) < INCHES else 1.0)
        first, second = (abs(size - nominal) for size in (profile.height, profile.width))
        return first <= NOMINAL * nominal < second
    match = _HALVED.fullmatch(profile.name)
    known = measures_of(match[1] or match[2]) if match else None
    if known is None or known[0] != "I":
        return False
    stem, flange = known[1][0] / 2, known[1][1]
    on_end = max(abs(profile.height - stem), abs(profile.width - flange))
    as_is = max(abs(profile.width - stem), abs(profile.height - flange))
    return on_end <= HALF < as_is
