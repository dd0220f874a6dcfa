"""Positions of comments between the rows of a DSTV file: the object that each precedes."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import zip_longest

from beamcam.model.anchors import anchor_key, plane_positions
from beamcam.model.part import Contour, Feature, FileComment, Plane
from beamcam.readers.dstv.blocks import Block
from beamcam.readers.dstv.contours import ContourRows

Stop = tuple[int, str]  #: a line that a comment can stand before, and its anchor


def place_comments(
    placed: list[tuple[int, str, str]], loose: list[tuple[int, str]], blocks: list[Block], end: int,
    features: Sequence[Feature], planes: Sequence[Plane], contours: Sequence[ContourRows],
) -> tuple[FileComment, ...]:  # fmt: skip
    """All comments of a file with their anchors, in the order in which a writer meets them.

    `placed` have their line and anchor already; `loose` are lines and texts between the blocks.
    """
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
    rows_of = {rows.line: rows for rows in contours}
    for i, feature in enumerate(features):
        line = feature.source.line or 0
        things.append((line, f"feature:{i}"))
        rows = rows_of.get(line)
        if rows is not None and isinstance(feature, Contour):
            # A comment stands between two rows, so that turning round puts it before the other one.
            own = sorted({*rows.lines, *rows.notch_lines})
            places = [len(own) - row if rows.turned else row for row in range(len(own))]
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
