"""Plates as a table cuts them: outline, openings beside it, notches, ends skew through them."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import atan2, cos, degrees, hypot, radians, sin, tan

import numpy as np
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import polylines
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.model.description import description
from beamcam.model.part import PLATE_FACES, Bevel, Contour, Hole, Part, Slot

SAG = 0.05  #: mm from a chord to its curve
ROUND = 24  #: places on a circle that are looked at


def outlines_of(part: Part) -> dict[int, Contour]:
    """The outer contours that are cut, by their indices."""
    return {
        k: f for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.kind == "outer" and f.process == "cut"
        and f.face in PLATE_FACES
    }  # fmt: skip


def header_outline(part: Part) -> list[Line]:
    """The outline of a plate by the header alone: at each end the angle between its edges in v."""
    low, high = [0.0, part.length], [0.0, part.length]  # x of both ends at y 0 and at the width
    for k, angle in enumerate((part.cuts.web_start, part.cuts.web_end)):
        shorter = part.profile.height * tan(radians(abs(angle)))
        shorter = -shorter if k else shorter
        side = low if (angle > 0.0) != bool(k) else high  # the other edge is the longest
        side[k] += shorter
    wide = part.profile.height
    corners = [(low[0], 0.0), (low[1], 0.0), (high[1], wide), (high[0], wide)]
    return [Line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def beside_faults(parts: Iterable[Part]) -> Iterator[Diagnostic]:
    """An error for each opening of a plate that has no place within an outline.

    A place lies within where a ray to the right crosses an outline an odd number of times.
    """
    for part in {id(part): part for part in parts}.values():
        openings = [(one, where) for one in part.features if (where := _places(one))]
        if not openings:
            continue
        outlines: list[Sequence[Curve]] = [one.curves for one in outlines_of(part).values()]
        if not outlines and part.measures is None:
            outlines = [header_outline(part)]
        rings = [_sides(one) for one in outlines]  # each by itself: one may be there twice
        for one, where in openings:
            if not any(_crossed(at, sides) % 2 for sides in rings for at in where):
                yield rules.BESIDE.at(getattr(one, "source", part.source), what=description(one))


def _is_plain(one: Contour) -> bool:
    """Whether it is a contour of a plate, and not of a drawing."""
    plain = one.process == "cut" and one.closed and one.face in PLATE_FACES
    return plain and one.layer is None and one.colour is None


def _places(one: object) -> Sequence[Point]:
    """Places of an opening that is cut: its middle, and round it; none of anything else."""
    if isinstance(one, Contour):
        if one.kind != "inner" or not _is_plain(one):
            return ()
        return [curve.point(t) for curve in one.curves for t in (0.0, 0.25, 0.5, 0.75)]
    if not isinstance(one, Hole | Slot) or one.kind == "mark" or one.face not in PLATE_FACES:
        return ()
    c, s, long, high = 1.0, 0.0, 0.0, 0.0
    if isinstance(one, Slot):
        c, s = cos(radians(one.angle)), sin(radians(one.angle))
        long, high = one.length / 2, one.height / 2
    turns = [radians(360.0 * k / ROUND) for k in range(ROUND)]
    r = one.diameter / 2
    middles = [
        (one.x + c * u - s * v, one.y + s * u + c * v) for u in (-long, long) for v in (-high, high)
    ]
    return [(one.x, one.y), *((x + r * cos(t), y + r * sin(t)) for x, y in middles for t in turns)]


def _sides(curves: Sequence[Curve]) -> Floats:
    """The chords of a closed outline, (n, 2, 2)."""
    points = polylines(curves, SAG).points
    return np.stack((points, np.roll(points, -1, axis=0)), axis=1)


def _crossed(at: Point, sides: Floats) -> int:
    """How many chords a ray from a place to the right crosses."""
    (x0, y0), (x1, y1) = sides[:, 0].T, sides[:, 1].T
    spans = (y0 > at[1]) != (y1 > at[1])
    share = (at[1] - y0[spans]) / (y1 - y0)[spans]
    return int(np.count_nonzero(x0[spans] + share * (x1 - x0)[spans] > at[0]))


# --- notches --------------------------------------------------------------------------------------

# What has to be cut of cut-outs that are open to the edge of their plate, and of its outline.

NEAR = 0.02  #: mm from the outline within which a side lies on it


def open_edges(
    part: Part, header: Sequence[Curve], outline: int, gone: Collection[int] = ()
) -> Mapping[int, list[Curve]]:
    """Of contours that are one with others what is an edge of the part, by their indices.

    Those `gone` take no steel. A plate that has no outline has that of its `header`, by the index
    `outline`. In the complex plane of a side of the outline, from 0 to 1, one that lies on it is
    part of the real axis.
    """
    kept: dict[int, list[Curve]] = {}
    plain = {k: f for k, f in enumerate(part.features) if isinstance(f, Contour) and _is_plain(f)}
    around: dict[int, Sequence[Curve]] = {
        k: f.curves for k, f in plain.items() if f.kind == "outer"
    } or {outline: header}
    for k, cut_out in plain.items():
        sides = cut_out.curves if cut_out.kind == "inner" and k not in gone else ()
        for o, whole in around.items():
            edge = kept.get(o, [*whole])
            lines = [(n, line) for n, line in enumerate(edge)
                     if isinstance(line, Line) and line.length > NEAR]  # fmt: skip
            under = ((c, n) for c, side in enumerate(sides) for n, line in reversed(lines)
                     if _lies_on_line(side, line))  # fmt: skip
            shared = dict(under)  # of several the first
            begins = [c for c in shared if (c - 1) % len(sides) not in shared]
            if len(begins) != 1:
                continue
            rest = [side for c, side in enumerate(sides) if c not in shared]
            ring = _sides(whole)
            if not rest or not all(_crossed(side.point(0.5), ring) % 2 for side in rest):
                continue
            kept[k], kept[o] = rest, []
            for n, line in enumerate(edge):
                over = [sides[c] for c in shared if shared[c] == n]
                if not over or not isinstance(line, Line):
                    kept[o].append(line)
                    continue
                ends = [at for side in over for at in (side.start, side.end)]
                first, last = (f(ends, key=lambda at: _on(line, at).real) for f in (min, max))
                pieces = (Line(line.start, first), Line(last, line.end))
                kept[o] += [piece for piece in pieces if piece.length > NEAR]
            break
    return kept


def _lies_on_line(side: Curve, line: Line) -> bool:
    slack, ends = NEAR / line.length, [_on(line, at) for at in (side.start, side.end)]
    return isinstance(side, Line) and all(
        abs(z.imag) <= slack and -slack <= z.real <= 1.0 + slack for z in ends
    )


def _on(line: Line, at: Point) -> complex:
    start = complex(*line.start)
    return (complex(*at) - start) / (complex(*line.end) - start)


# --- skew ends ------------------------------------------------------------------------------------

# Edges of plates at which a header has an end skew through the thickness: required square.

SKEW_DEG = 1.0  #: of an angle in a header; less is noise of who wrote the file
ON_EDGE = 1.0  #: mm that the edge of an outline may lie off the end that it is

Edge = tuple[Point, Point, float]  #: its ends, and degrees that it leans under face v


def skew_ends(parts: Sequence[Part], machine: Machine) -> Iterator[Diagnostic]:
    """Ends that a header has skew through the thickness, where no bevel of an outline says more."""
    least = max(SKEW_DEG, machine.torch.min_bevel if machine.torch is not None else 0.0)
    for part in parts:
        if not any(contour.bevels for contour in part.contours):
            for end, angle in (("start", part.cuts.flange_start), ("end", part.cuts.flange_end)):
                if abs(angle) >= least:
                    yield rules.SKEW_END.at(part.source, end=end, found=f"{angle:g}")


def with_skew_edges(part: Part, torch: Torch) -> Part:
    """A plate with its skew ends as bevels of its outline, if all of them are edges of that."""
    is_plate = part.profile.code == "B" and part.measures is None and part.profile.height > 0.0
    if not is_plate or any(contour.bevels for contour in part.contours):
        return part
    start, end = _edge(part, 0), _edge(part, 1)
    skew = [e for e, deg in ((start, part.cuts.flange_start), (end, part.cuts.flange_end))
            if abs(deg) >= max(SKEW_DEG, torch.min_bevel)]  # fmt: skip
    features, outer = list(part.features), outlines_of(part)
    if not outer:
        ring = (start[0], end[0], end[1], start[1], start[0])
        sides = tuple(map(Line, ring[:-1], ring[1:]))
        outer = {len(features): Contour("v", "outer", sides, part.source)}
        features += outer.values()
    met: set[Edge] = set()
    for k, outline in outer.items():
        on = [
            (c, edge) for c, side in enumerate(outline.curves) for edge in skew
            if isinstance(side, Line) and _lies_on(side.start, edge) and _lies_on(side.end, edge)
        ]  # fmt: skip
        met.update(edge for _, edge in on)
        if on:
            features[k] = replace(outline, bevels=tuple(Bevel(c, deg, 0.0) for c, (*_, deg) in on))
    return replace(part, features=tuple(features)) if skew and len(met) == len(skew) else part


def _edge(part: Part, at_end: int) -> Edge:
    """The edge of an end of a plate where it is longest, of its corners on both faces."""
    cuts = part.cuts
    pair = (cuts.web_end, cuts.flange_end) if at_end else (cuts.web_start, cuts.flange_start)
    by_y, by_z = (tan(radians(deg)) for deg in pair)
    high, thick = part.profile.height, part.profile.web_thickness or 0.0
    lean = {(y, z): -y * by_y - z * by_z for y in (0.0, high) for z in (0.0, thick)}
    # The outermost corner lies at x 0, or at the length.
    shift = part.length - max(lean.values()) if at_end else -min(lean.values())
    outermost = max if at_end else min
    low, top = (shift + outermost(lean[y, 0.0], lean[y, thick]) for y in (0.0, high))
    shorter = (lean[0.0, 0.0] - lean[0.0, thick]) * (1.0 if at_end else -1.0)  # v than h, along x
    across = shorter * high / hypot(high, top - low)
    return (low, 0.0), (top, high), degrees(atan2(across, thick))


def _lies_on(place: Point, edge: Edge) -> bool:
    (x0, _), (x1, high), _ = edge
    return abs(place[0] - x0 - (x1 - x0) * place[1] / high) <= ON_EDGE
