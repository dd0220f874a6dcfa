"""The DSTV reader (.nc, .nc1): 7th edition of the standard, and what real files make of it."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import zip_longest

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.model.part import (
    MIRRORED_FACES,
    Contour,
    Feature,
    FileComment,
    Hole,
    Plane,
    Profile,
    SectionPoint,
)
from beamcam.readers import Reading
from beamcam.readers.dstv import rows, rules
from beamcam.readers.dstv.blocks import (
    CODES,
    Block,
    Log,
    decode,
    decode_as,
    split_blocks,
    split_lines,
)
from beamcam.readers.dstv.contours import ContourRows, build_contour, is_mirrored, read_contour_rows
from beamcam.readers.dstv.header import header_lines, read_header, upright
from beamcam.readers.dstv.lint import Ends, check, with_ends

#: What stands before the rows of features that are there, and what says that the ends are.
MADE, MADE_ENDS = "**BEAMCAM MADE ", "ENDS"
#: Blocks of contours by the letter that their rows go by.
_CONTOURS = {"AK": "A", "IK": "I", "KO": "K", "PU": "P"}
#: Blocks on planes by their letter: the block on faces that has the same rows.
_ON_PLANES = {"B": "BO", "S": "SI", "A": "AK", "I": "IK", "K": "KO", "P": "PU", "E": "E"}

Placed = tuple[int, str, str]  #: line, anchor and text of a comment


class BlockContent(Struct):
    """What the blocks of a file give the part."""

    features: list[Feature | ContourRows] = field(default_factory=list)
    planes: list[Plane] = field(default_factory=list)
    section: list[SectionPoint] = field(default_factory=list)
    info: list[tuple[str, str]] = field(default_factory=list)
    tolerance: tuple[float, float] | None = None
    contours: list[ContourRows] = field(default_factory=list)
    plane_names: dict[str, str] = field(default_factory=dict)  #: by digit, the last plane's name


def looks_like(data: bytes) -> bool:
    """Whether the bytes are a DSTV file by their lines: a line ST, or two codes of its own."""
    lines = {line.strip() for line in split_lines(decode(data[:20000])[0])}
    return "ST" in lines or len(lines & {"EN", "BO", "AK", "IK", "SI", "KO"}) >= 2


def read(data: bytes, name: str, encoding: str | None = None, ends: Ends | None = None) -> Reading:
    """The part of a DSTV file and its diagnostics; never raises.

    `name` is the file's name for messages. Where the header cannot be read there is no part.
    `encoding` is that of its text; by default it is recognised by the letters. `ends` says which
    counts where header and contour describe different ends.
    """
    return read_with_account(data, name, encoding, ends)[0]


def read_with_account(
    data: bytes, name: str, encoding: str | None = None, ends: Ends | None = None
) -> tuple[Reading, Log]:
    """As `read`, with the account of the file's lines."""
    log = Log(name)
    if encoding is None:
        text, guessed = decode(data)
    else:
        text, guessed = decode_as(data, encoding, log), None
    lines = split_lines(text)
    texts = [*map(str.strip, lines)]
    if guessed is not None:
        line = next((i for i, row in enumerate(lines, 1) if not row.isascii()), 1)
        log.add(rules.ENCODING, line, encoding=guessed)
    start, comments = _find_start(texts, log)
    if start is None:
        return _refused(texts, log)
    head = header_lines(lines, texts, start)
    header = read_header(head, Source(name, start), log)
    if header is None:
        return _refused(texts, log)
    made = None
    if MADE in text and any(row.startswith(MADE) for row in texts[head.end :]):
        made = _made(texts, head.end, name)
        texts = ["" if text.startswith(MADE) else text for text in texts]
    comments += [(0, f"header:{n}", text) for n, text in head.comments]
    blocks, loose, end = split_blocks(lines, texts, head.end, log)
    log.data_lines = head.numbers + [number for block in blocks for number in block.numbers]
    loose = head.trailing + loose
    for number in head.numbers + [n for block in blocks for n in block.numbers[:1]]:
        begin = lines[number - 1][:2]
        if begin != "  " and texts[number - 1] and begin[0] != "\t":
            log.add(rules.INDENT, number)
            break
    content = BlockContent()
    for block in blocks:
        _read_block(block, content, header.profile, log)
    features = tuple(_finish_contours(content, header.profile, log))
    anchored = tuple(FileComment(text, anchor) for _, anchor, text in comments)
    if loose:
        anchored = _place_comments(
            comments, loose, blocks, end, features, content.planes, content.contours
        )
    part = replace(
        header, features=features, planes=tuple(content.planes), tolerance=content.tolerance,
        section=tuple(content.section), info=tuple(content.info), comments=anchored,
        made=None if made is None else made.parts[0].features if made.parts else (),
    )  # fmt: skip
    log.diagnostics += () if made is None else made.diagnostics
    if (other := upright(data, part, head.numbers, log)) is not None:
        remark = log.diagnostics[-1]
        reading, log = read_with_account(other, name, encoding, ends)
        return replace(reading, diagnostics=(remark, *reading.diagnostics)), log
    if ends is not None:
        part = with_ends(part, ends, head.numbers, log)
    check(part, content.contours, head.numbers, log)
    log.diagnostics.sort(key=lambda d: d.source.line or 0)
    return Reading("dstv", (part,), tuple(log.diagnostics)), log


def _made(texts: list[str], head: int, name: str) -> Reading:
    """What stands in comments as made already: a file of its own below the same header.

    Its rows keep their lines; what is said of the header, which ends at line `head`, is not
    repeated.
    """
    made = [text.removeprefix(MADE) if text.startswith(MADE) else "" for text in texts[head:]]
    # A row of such a comment is no comment of its own.
    made = ["" if row == MADE_ENDS or row.startswith(MADE) else row for row in made]
    data = "\n".join([*texts[:head], *made, "EN"]).encode()
    reading, _ = read_with_account(data, name, "utf-8")
    diagnostics = tuple(d for d in reading.diagnostics if (d.source.line or 0) > head)
    return replace(reading, diagnostics=diagnostics)


def _refused(texts: list[str], log: Log) -> tuple[Reading, Log]:
    """No part, and a note of how many lines were not looked at."""
    known_lines = {d.source.line for d in log.diagnostics}
    data_lines = [i for i, text in enumerate(texts, 1) if text and text[:2] != "**"]
    unread = [i for i in data_lines if i not in known_lines]
    if unread:
        log.add(rules.UNREAD, unread[-1], count=len(unread))
        log.left_out += unread
    log.diagnostics.sort(key=lambda d: d.source.line or 0)
    return Reading("dstv", (), tuple(log.diagnostics)), log


def _find_start(texts: list[str], log: Log) -> tuple[int | None, list[Placed]]:
    """Index behind the line ST, and the comments before it; None if there is none."""
    comments: list[Placed] = []
    data: list[tuple[int, str]] = []
    for index, text in enumerate(texts):
        if text[:2] == "ST" and text[2:].lstrip()[:2] == "**":
            log.add(rules.COMMENT_INLINE, index + 1)
            comments.append((index + 1, "start", text[2:].lstrip()[2:]))
            text = "ST"
        if text == "ST" or (text == "st" and not data):
            if data:
                log.add(rules.BEFORE_ST, data[0][0], found=data[0][1], count=len(data))
                log.left_out.extend(number for number, _ in data)
            if text == "st":
                log.add(rules.CODE_CASE, index + 1, found=text, block="ST")
            return index + 1, comments
        if text[:2] == "**":
            comments.append((index + 1, "start", text[2:]))
        elif text:
            data.append((index + 1, text))
    number, found = data[0] if data else (1, "nothing")
    log.add(rules.NOT_DSTV if CODES.isdisjoint(texts) else rules.NO_ST, number, found=found)
    return None, comments


def _read_block(block: Block, content: BlockContent, profile: Profile, log: Log) -> None:
    """Add what a block says to `content`."""
    code, plane = _code_and_plane(block, content, log)
    place = rows.RowPlace(log, profile, plane)
    if code in rows.FEATURES:
        content.features.extend(rows.features_of(block, place, *rows.FEATURES[code]))
    elif code in _CONTOURS:
        contours = read_contour_rows(block, _CONTOURS[code], place)
        content.features.extend(contours)
        content.contours.extend(contours)
    elif code == "SC":
        content.features.extend(rows.read_end_planes(block, log))
    elif code == "E":  # a number that is used again names another plane
        last = content.plane_names.get(block.code[1])
        name = block.code if last is None else f"{block.code}#{int(last[3:] or 1) + 1}"
        if (read := rows.read_plane(block, name, log)) is not None:
            content.planes.append(read)
        content.plane_names[block.code[1]] = name
    elif code == "PR":
        content.section.extend(
            rows.features_of(block, place, rows.read_section_point, rules.SECTION_FIELDS)
        )
        if profile.code != "SO":
            log.add(rules.SECTION_CODE, block.line, code=profile.code)
    elif code == "IN":
        content.info.extend(rows.read_info(block, log))
    elif code == "TO":
        if content.tolerance is not None:
            log.add(rules.BLOCK_REPEATED, block.line, block="TO")
        content.tolerance = rows.read_tolerance(block, log) or content.tolerance
    else:
        if block.code == "ST":
            log.add(rules.SECOND_ST, block.line)
        elif block.code:
            log.add(rules.BLOCK_UNKNOWN, block.line, found=block.code, count=len(block.rows))
        for line, row in zip(block.numbers, block.rows, strict=True):
            log.add(rules.ROW_LOST, line, found=row, block=block.code or "the header")


def _code_and_plane(block: Block, content: BlockContent, log: Log) -> tuple[str, str]:
    """The code on faces whose rows a block has, "E" of a plane itself; and the plane that the
    block lies on, "" for the faces."""
    code = block.code
    if not code[1:].isdigit():
        return code, ""
    letter, digit = code[0], code[1]
    known = _ON_PLANES.get(letter, code)
    if letter == "E":
        return known, ""
    has_faces = bool(block.rows) and block.rows[0][0].lower() in rows.FACE_LETTERS
    if code == "B0" and "0" not in content.plane_names and has_faces:
        log.add(rules.CODE_ZERO, block.line)
        return known, ""
    if digit not in content.plane_names:
        log.add(rules.PLANE, block.line, block=code, plane="E" + digit)
    return known, content.plane_names.get(digit, "E" + digit)


def _finish_contours(content: BlockContent, profile: Profile, log: Log) -> Iterator[Feature]:
    """The features in order, contour rows made into contours where they make one."""
    mirrored: dict[str, bool] = {}  # by face, whether its first outer contour is
    for outer in content.contours:
        if outer.code == "A" and outer.face in MIRRORED_FACES:
            mirrored.setdefault(outer.face, bool(outer.points) and is_mirrored(outer))
    for item in content.features:
        if type(item) is not ContourRows:
            yield item
            continue
        flip = False
        if item.face in MIRRORED_FACES and item.points:
            known = mirrored.get(item.face)
            flip = known if known is not None else item.code in "KP" or is_mirrored(item)
        if item.code == "K" and len(item.points) == 1:  # a punch mark
            (x, y), line = item.points[0], item.lines[0]
            log.add(rules.SINGLE_PUNCH, line)
            log.taken.append(line)
            source = Source(log.file, line)
            yield Hole(item.face, x, y, 0.0, source, None, "mark", None, item.edge)
            continue
        thickness = profile.thickness(item.face) if item.face in "vouh" else 0.0
        if (contour := build_contour(item, flip, thickness, log)) is not None:
            yield contour


# --- comments ------------------------------------------------------------------------------------

# Positions of comments between the rows of a file: the object that each precedes.


Stop = tuple[int, str]  #: a line that a comment can stand before, and its anchor


def _place_comments(
    placed: list[tuple[int, str, str]], loose: list[tuple[int, str]], blocks: list[Block], end: int,
    features: Sequence[Feature], planes: Sequence[Plane], contours: Sequence[ContourRows],
) -> tuple[FileComment, ...]:  # fmt: skip
    """All comments of a file with their anchors, in the order in which a writer meets them.

    `placed` have their line and anchor already; `loose` are lines and texts between the blocks.
    """
    from beamcam.model.anchors import anchor_key, plane_positions

    stops = _stops(blocks, features, planes, contours)
    lines = [line for line, _ in stops]
    comments = list(placed)
    for line, text in loose:
        if end and line > end:
            anchor = "after-end"
        else:
            at = bisect_right(lines, line)
            anchor = stops[at][1] if at < len(stops) else "end"
        comments.append((line, anchor, text))
    positions = plane_positions(planes, features)
    comments.sort(key=lambda item: anchor_key(item[1], positions))
    return tuple(FileComment(text, anchor) for _, anchor, text in comments)


def _stops(
    blocks: list[Block], features: Sequence[Feature], planes: Sequence[Plane],
    contours: Sequence[ContourRows],
) -> list[Stop]:  # fmt: skip
    """Every line that a comment can stand before, in order, with its anchor."""
    things: list[Stop] = []
    contour_at = {contour.line: contour for contour in contours}
    for i, feature in enumerate(features):
        line = feature.source.line or 0
        things.append((line, f"feature:{i}"))
        drawn = contour_at.get(line)
        if drawn is not None and isinstance(feature, Contour):
            # A comment stands between two rows, so that turning round puts it before the other one.
            own = sorted({*drawn.lines, *drawn.notch_lines})
            places = [len(own) - row if drawn.turned else row for row in range(len(own))]
            things += [(own[k], f"feature:{i}:{place}") for k, place in enumerate(places) if k]
    block_at = {block.line: block for block in blocks}
    for k, plane in enumerate(planes):
        block = block_at[plane.source.line or 0]
        things += [
            (line, f"plane:{k}:{row}" if row else f"plane:{k}")
            for row, line in enumerate(block.numbers[:3])
        ]
    counts = {"PR": 0, "IN": 0}
    for block in blocks:
        if block.code in counts:
            name = "section" if block.code == "PR" else "info"
            for line in block.numbers:
                things.append((line, f"{name}:{counts[block.code]}"))
                counts[block.code] += 1
        elif block.code == "TO" and block.numbers:
            things.append((block.numbers[0], "tolerance"))
    things.sort()
    lines = [line for line, _ in things]
    for block, limit in zip_longest(blocks, [block.line for block in blocks[1:]]):
        at = bisect_right(lines, block.line)
        if at < len(lines) and (limit is None or lines[at] < limit):
            things.append((block.line, "block:" + things[at][1]))
    things.sort()
    return things
