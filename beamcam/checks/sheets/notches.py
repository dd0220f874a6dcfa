"""What has to be cut of cut-outs that are open to the edge of their plate, and of its outline."""

from collections.abc import Collection, Mapping, Sequence

from beamcam.checks.sheets.beside import crossed, sides_of
from beamcam.geometry.curves import Curve, Line
from beamcam.model.part import PLATE_FACES, Contour, Part

NEAR = 0.02  #: mm from the outline within which a side lies on it

Kept = dict[int, list[Curve]]


def open_edges(
    part: Part, header: Sequence[Curve], outline: int, gone: Collection[int] = ()
) -> Mapping[int, list[Curve]]:
    """Of contours that are one with others what is an edge of the part, by their indices.

    Those `gone` take no steel.

    A plate that has no outline has that of its `header`, by the index `outline`. In the complex
    plane of a side of the outline, from 0 to 1, one that lies on it is a stretch of the real axis.
    """
    kept: Kept = {}
    plain = {
        k: f for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.process == "cut" and f.face in PLATE_FACES and f.closed
        and f.layer is None and f.colour is None
    }  # fmt: skip
    cut_outs = {k: f.curves for k, f in plain.items() if f.kind == "inner" and k not in gone}
    if not cut_outs:
        return kept
    around: dict[int, Sequence[Curve]] = {
        k: f.curves for k, f in plain.items() if f.kind == "outer"
    } or {outline: header}
    for k, sides in cut_outs.items():
        for o, whole in around.items():
            edge = kept.get(o, [*whole])
            shared = {c: n for c, side in enumerate(sides) if (n := _line_under(side, edge)) >= 0}
            begins = [c for c in shared if (c - 1) % len(sides) not in shared]
            if len(begins) != 1:
                continue
            rest = [side for c, side in enumerate(sides) if c not in shared]
            ring = sides_of(whole)
            if not rest or not all(crossed(side.point(0.5), ring) % 2 for side in rest):
                continue
            kept[k] = rest
            kept[o] = [
                piece for n, line in enumerate(edge)
                for piece in _beside(line, [sides[c] for c in shared if shared[c] == n])
            ]  # fmt: skip
            break
    return kept


def _line_under(side: Curve, edge: Sequence[Curve]) -> int:
    """Which line of an outline a straight side lies on; -1 for none."""
    if isinstance(side, Line):
        for n, line in enumerate(edge):
            if isinstance(line, Line) and line.length > NEAR:
                slack = NEAR / line.length
                on = [_on(line, at) for at in (side.start, side.end)]
                if all(abs(z.imag) <= slack and -slack <= z.real <= 1.0 + slack for z in on):
                    return n
    return -1


def _on(line: Line, at: tuple[float, float]) -> complex:
    start = complex(*line.start)
    return (complex(*at) - start) / (complex(*line.end) - start)


def _beside(line: Curve, gone: Sequence[Curve]) -> list[Curve]:
    """What stays of a line of an outline before and behind the sides that lie on it."""
    if not gone or not isinstance(line, Line):
        return [line]
    ends = sorted((p for side in gone for p in (side.start, side.end)),
                  key=lambda at: _on(line, at).real)  # fmt: skip
    pieces = [Line(line.start, ends[0]), Line(ends[-1], line.end)]
    return [piece for piece in pieces if piece.length > NEAR]
