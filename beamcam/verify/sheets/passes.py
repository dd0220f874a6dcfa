"""Contours that are followed several times: passes one after the other, taken for one stroke."""

from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from beamcam.controllers.moves import Moves
from beamcam.machine.torch import TorchRow
from beamcam.verify.sheets.strokes import HeadStroke, Strokes


def passes_folded(strokes: Strokes, rows: Iterable[TorchRow]) -> Strokes:
    """Strokes of which each counts its passes; equal ones count as such only behind one another.

    Where no row has more than one pass the strokes come back as they are.
    """
    if all(row.passes == 1 for row in rows):
        return strokes
    each: list[HeadStroke] = []
    kept: list[range] = []
    count = 0
    for stroke in strokes.each:
        if kept and _is_repeat(each[-1], kept[-1], stroke, strokes.moves):
            each[-1] = replace(each[-1], passes=each[-1].passes + 1)
            continue
        kept.append(range(stroke.first, stroke.last))
        last = count + len(kept[-1])
        each.append(replace(stroke, first=count, last=last))
        count = last
    rows_kept = np.concatenate([np.zeros(0, dtype=np.int64), *(np.array(span) for span in kept)])
    return Strokes(each, strokes.moves.take(rows_kept.astype(np.int64)))


def _is_repeat(first: HeadStroke, span: range, other: HeadStroke, moves: Moves) -> bool:
    """Whether a stroke repeats the path of one before it, with the same words."""
    said = (first.row, first.side, first.radius, len(span))
    if said != (other.row, other.side, other.radius, other.last - other.first):
        return False
    a, b = slice(span.start, span.stop), slice(other.first, other.last)
    columns = (moves.start, moves.end, moves.is_arc, moves.arcs, moves.feed_mm_min)
    if not all(np.array_equal(column[a], column[b]) for column in columns):
        return False
    pairs = zip(span, range(other.first, other.last), strict=True)
    return all(moves.curves.get(i) == moves.curves.get(k) for i, k in pairs)
