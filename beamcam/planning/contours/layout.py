"""How a part is laid for the machine: mirrored, turned, in copies; its parts moved apart."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from math import hypot

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line, signed_area
from beamcam.geometry.plane import (
    Matrix,
    Point,
    determinant,
    groups_of,
    mapped,
    mapped_vector,
    unit_vector,
)
from beamcam.machine.torch import Torch
from beamcam.model.colour import key_of
from beamcam.model.part import Contour, Feature, Hole, Part, Slot, TextMark, moved_feature
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import outlines, reach_of, with_outline


def cannot_lie(part: Part, torch: Torch) -> Iterator[tuple[Source, str]]:
    """Features that cannot be mirrored, turned or copied: where they are, and what they are."""
    for feature in part.features:
        if isinstance(feature, Contour):
            if feature.bevels:
                yield feature.source, "a bevelled contour"
        elif isinstance(feature, TextMark):
            if torch.mirror != "none":
                yield feature.source, "a text, which would be read from behind"
        elif not isinstance(feature, Hole | Slot):
            yield getattr(feature, "source", part.source), type(feature).__name__.lower()


def size_of(part: Part, torch: Torch) -> tuple[float, float]:
    """Length and width of all copies together, with the spacing between them."""
    x0, y0, x1, y1 = reach_of(_as_turned(part, torch))
    (columns, rows), gap = torch.copies, torch.spacing
    return columns * (x1 - x0 + gap) - gap, rows * (y1 - y0 + gap) - gap


def laid_out(part: Part, torch: Torch) -> Part:
    """The part with all its copies: mirrored and turned about its middle, then repeated.

    Copies stand side by side in X and above each other in Y, their boxes `spacing` apart.
    """
    turned = _as_turned(part, torch)
    x0, y0, x1, y1 = reach_of(turned)
    columns, rows = torch.copies
    features = [
        _placed(feature, ((1.0, 0.0, k * (x1 - x0 + torch.spacing)),
                          (0.0, 1.0, n * (y1 - y0 + torch.spacing))))
        for n in range(rows) for k in range(columns) for feature in turned.features
    ]  # fmt: skip
    length, width = size_of(part, torch)
    return replace(
        turned, features=tuple(features), length=length,
        profile=replace(part.profile, height=width),
    )  # fmt: skip


def _as_turned(part: Part, torch: Torch) -> Part:
    whole = with_outline(part)
    if torch.mirror == "none" and not torch.rotate:
        return whole
    x0, y0, x1, y1 = reach_of(whole)
    (c, s), (mx, my) = unit_vector(torch.rotate), ((x0 + x1) / 2, (y0 + y1) / 2)
    fx, fy = (-1.0 if torch.mirror == axis else 1.0 for axis in ("x", "y"))
    a, b, d, e = c * fx, -s * fy, s * fx, c * fy
    matrix = (a, b, mx - a * mx - b * my), (d, e, my - d * mx - e * my)
    return replace(whole, features=tuple([_placed(f, matrix) for f in whole.features]))


def _placed(feature: Feature, matrix: Matrix) -> Feature:
    """A feature moved by a matrix that keeps lengths; a contour goes round as it did."""
    if isinstance(feature, Contour):
        is_moved = matrix[0][:2] == (1.0, 0.0) and matrix[1][:2] == (0.0, 1.0)
        curves: list[Curve] = [
            # An arc that is only moved keeps its angles as they are.
            replace(curve, centre=mapped(matrix, curve.centre))
            if is_moved and isinstance(curve, Arc) else curve.transformed(matrix)
            for curve in feature.curves
        ]  # fmt: skip
        notches = [replace(n, corner=mapped(matrix, n.corner)) for n in feature.notches]
        if determinant(matrix) < 0.0:
            last = len(curves) - 1
            curves = [curve.reversed() for curve in reversed(curves)]
            notches = [replace(notch, curve=last - notch.curve) for notch in notches]
        return replace(feature, curves=tuple(curves), notches=tuple(notches))
    if isinstance(feature, Hole | Slot | TextMark):
        x, y = mapped(matrix, (feature.x, feature.y))
        if isinstance(feature, Hole):
            return replace(feature, x=x, y=y)
        angle = direction_deg(mapped_vector(matrix, unit_vector(feature.angle)))
        return replace(feature, x=x, y=y, angle=angle)
    return feature


# --- common cuts ----------------------------------------------------------------------------------

# Parts of a drawing that touch, moved apart by the kerf so that one cut goes between them.
#
#  _______ _______          _______   _______      Across each upright edge that two parts share
# |       |       |        |       | |       |     the one at its right lies a kerf farther to
# |   1   |   2   |   ->   |   1   | |   2   |     the right of the other than it was drawn, across
# |_______|_______|        |_______| |_______|     each level edge the upper one a kerf higher.
#
# Where parts share a slanting edge too, all of those that touch are moved square to their edges:
# the first stays, the others go as little as that takes, by the sum of squares.


AXES: tuple[Point, Point] = ((1.0, 0.0), (0.0, 1.0))
#: A contour at the left of an edge or below it, the one behind that, and the direction across.
Edge = tuple[int, int, Point]
NO_MOVE: Point = (0.0, 0.0)
AGREES = 1e-6  #: of a kerf, by which the moves of parts may differ
SAME = 1e-4  #: mm that edges of two parts may be apart to be one
UPRIGHT = 1e-6  #: of a direction, by which an edge is upright or level
FINE = 0.01  #: mm that chords may be off, to tell what lies in a part


def spread(part: Part, torch: Torch, kerf: float) -> tuple[Part, list[Diagnostic]]:
    """The drawing with the parts that share edges moved apart by the kerf, and a note on it.

    As it is drawn where they share curves, or where the moves of some contradict one another.
    """
    if not torch.common_cuts or not kerf or part.measures is None:
        return part, []
    import shapely

    rings = {
        k: f for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.curves[0].start == f.curves[-1].end
        and (key := key_of(f, torch.colours)) is not None and torch.colours[key] == "cut"
    }  # fmt: skip
    polygons = list(outlines([ring.curves for ring in rings.values()], FINE)) if rings else []
    outer = {
        k: ring for k, ring in zip(rings, polygons, strict=True)
        if not any(ring.area < other.area and other.covers(ring.representative_point())
                   for other in polygons)
    }  # fmt: skip
    edges = _edges({k: rings[k] for k in outer})
    if not edges:
        return part, []
    moves: dict[int, Point] = {}
    for group in groups_of((before, behind) for before, behind, _ in edges):
        own = [edge for edge in edges if edge[0] in group]
        is_slant = any(across not in AXES for *_, across in own)
        apart = (_least_moves if is_slant else _level_moves)(sorted(group), own)
        if apart is None:
            return part, []
        moves |= {k: (kerf * x, kerf * y) for k, (x, y) in apart.items()}

    def around(at: Point) -> list[int]:
        return [k for k, ring in outer.items() if shapely.covers(ring, shapely.Point(at))]

    features = list(part.features)
    for k, feature in enumerate(features):
        home = [k] if k in outer else []
        if not home and isinstance(feature, Contour):
            home = around(feature.curves[0].point(0.5))
        elif isinstance(feature, Hole | Slot):
            home = around((feature.x, feature.y))
        if home and moves.get(home[0], NO_MOVE) != NO_MOVE:
            features[k] = moved_feature(feature, moves[home[0]])
    count = sum(move != NO_MOVE for move in moves.values())
    note = rules.APART.at(part.source, count=count, kerf=f"{kerf:g}")
    return replace(part, features=tuple(features)), [note]


def _edges(contours: Mapping[int, Contour]) -> list[Edge]:
    """The edges that two contours share, one on each side of them; none if they share a curve."""
    from beamcam.geometry.arrays import CurveTable, overlapping

    curves = [curve for contour in contours.values() for curve in contour.curves]
    owners = [k for k, contour in contours.items() for _ in contour.curves]
    turns = {k: 1.0 if signed_area(one.curves) > 0.0 else -1.0 for k, one in contours.items()}
    edges: list[Edge] = []
    for a, b in overlapping(CurveTable(curves), ["cut"] * len(curves)):
        one, other, before, behind = curves[a], curves[b], owners[a], owners[b]
        if before == behind:
            continue
        if not (isinstance(one, Line) and isinstance(other, Line)):
            return []
        x, y = _out(one, turns[before])
        u, v = _out(other, turns[behind])
        (px, py), (qx, qy) = one.start, other.start
        if x * u + y * v > 0.0 or abs((qx - px) * x + (qy - py) * y) > SAME:
            continue
        if x < -UPRIGHT or (abs(x) <= UPRIGHT and y < 0.0):
            before, behind, x, y = behind, before, -x, -y
        if min(abs(x), abs(y)) <= UPRIGHT:
            x, y = AXES[0] if x > 0.5 else AXES[1]
        edges.append((before, behind, (x, y)))
    return edges


def _out(line: Line, side: float) -> Point:
    """The direction in which a part ends at an edge; `side` is 1 if it runs counter-clockwise."""
    (x0, y0), (x1, y1) = line.start, line.end
    size = hypot(x1 - x0, y1 - y0) or 1.0
    return side * (y1 - y0) / size, side * (x0 - x1) / size


def _least_moves(group: Sequence[int], edges: Sequence[Edge]) -> dict[int, Point] | None:
    """The moves of least squares, the first part resting, that part all edges by one kerf."""
    import numpy as np

    columns = {n: 2 * k for k, n in enumerate(group[1:])}
    rows = np.zeros((len(edges), 2 * len(columns)))
    for row, (before, behind, across) in zip(rows, edges, strict=True):
        for number, sign in ((before, -1.0), (behind, 1.0)):
            if number in columns:
                row[columns[number] : columns[number] + 2] += sign * np.array(across)
    solved = np.linalg.lstsq(rows, np.ones(len(edges)), rcond=None)[0]
    if np.abs(rows @ solved - 1.0).max() > AGREES:
        return None
    moves = {n: (float(solved[k]), float(solved[k + 1])) for n, k in columns.items()}
    return {group[0]: NO_MOVE, **moves}


def _level_moves(group: Sequence[int], edges: Sequence[Edge]) -> dict[int, Point] | None:
    """How many kerfs each part is moved along both axes; None where edges contradict one another.

    Of parts that touch, directly or by others, the first is not moved back: the least of them is 0.
    """
    moves = {k: [0.0, 0.0] for k in group}
    for axis in (0, 1):
        beside: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for before, behind, _ in (edge for edge in edges if edge[2] == AXES[axis]):
            beside[before].append((behind, 1))
            beside[behind].append((before, -1))
        left = list(group)
        while left:
            moved, waiting = {left[0]: 0}, [left[0]]
            for here in waiting:
                for there, step in beside[here]:
                    if moved.setdefault(there, moved[here] + step) != moved[here] + step:
                        return None
                    waiting += [there] if there not in waiting else []
            least = min(moved.values())
            for k, step in moved.items():
                moves[k][axis] = float(step - least)
            left = [k for k in left if k not in moved]
    return {k: (x, y) for k, (x, y) in moves.items()}
