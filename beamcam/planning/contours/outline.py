"""Contours: their curves and where they begin, as polygons and polylines, and their shapes."""

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from math import dist
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line, parameter_at, unit_vector
from beamcam.geometry.plane import Box, Point, between, distance, dot, join_boxes
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.description import description, end_lines
from beamcam.model.part import PLATE_FACES, Contour, Feature, Hole, Part, Slot, extent
from beamcam.planning.contours import rules

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from beamcam.geometry.array_types import Floats

Curves = tuple[Curve, ...]


def reversed_chain(curves: Sequence[Curve]) -> Curves:
    """The chain followed backwards."""
    return tuple([c.reversed() for c in reversed(curves)])


def waste_side(area: float, is_hole: bool) -> int:
    """1 if what falls out lies left of a closed contour of that signed area, -1 if right."""
    return 1 if (area > 0.0) == is_hole else -1


def is_turned(area: float, is_hole: bool, torch: Torch) -> bool:
    """Whether a closed contour of that signed area has to be followed backwards.

    Climb keeps the remaining material on the right of the head, as the swirl of a plasma torch
    wants it: outer contours clockwise, holes counter-clockwise.
    """
    if torch.direction == "drawn":
        return False
    is_counterclockwise = is_hole if torch.direction == "climb" else not is_hole
    return (area > 0.0) != is_counterclockwise


def begun(curves: Curves, torch: Torch, here: Point, is_pierced: bool = True) -> Curves:
    """A closed contour from where the machine begins it, the head being at `here`.

    What is only marked is not pierced: no line of it is divided.
    """
    if torch.start == "drawn":
        return curves
    if torch.start == "straight" and is_pierced:
        return from_longest(curves, range(len(curves)))
    if len(curves) == 1:
        (curve,) = curves
        if isinstance(curve, Arc) and here != curve.centre:
            toward = (here[0] - curve.centre[0], here[1] - curve.centre[1])
            return (Arc(curve.centre, curve.radius, direction_deg(toward), curve.sweep_deg),)
        return curves
    nearest = min(range(len(curves)), key=lambda k: dist(curves[k].start, here))
    return (*curves[nearest:], *curves[:nearest])


def from_longest(curves: Curves, which: Sequence[int]) -> Curves:
    """A closed contour from the middle of the longest line among some of its curves.

    Of the longest curve where none of them is a line.
    """
    lines = [k for k in which if isinstance(curves[k], Line)]
    # To a millionth: of equal ones the first, whatever the last digits of their ends are.
    longest = max(lines or which, key=lambda k: round(dist(curves[k].start, curves[k].end), 6))
    first, last = curves[longest].split(0.5)
    return (last, *curves[longest + 1 :], *curves[:longest], first)


def stretch(curves: Curves, lengths: Sequence[float], low: float, high: float) -> Curves:
    """The part of a chain between two lengths along it."""
    pieces: list[Curve] = []
    done = 0.0
    for piece, length in zip(curves, lengths, strict=True):
        a, b = max(low - done, 0.0), min(high - done, length)
        if b - a > 1e-9:
            if b < length:
                piece = piece.split(parameter_at(piece, b))[0]
            if a > 0.0:
                piece = piece.split(parameter_at(piece, a))[1]
            pieces.append(piece)
        done += length
    return tuple(pieces)


#: Points of chains, and the chain of each.
Drawn = tuple["Floats", "NDArray[np.int64]"]


def outlines(chains: Sequence[Sequence[Curve]], tolerance: float) -> "NDArray[Any]":
    """The polygon of each closed chain, an array of shapely polygons."""
    return rings_of(*points_of(chains, tolerance), len(chains))


def rings_of(points: "Floats", owner: "NDArray[np.int64]", count: int) -> "NDArray[Any]":
    """Polygons by their points, of which each has the number of its polygon, below `count`."""
    import numpy as np
    import shapely

    # A ring needs four points: chains of two curves that flatten to chords get their ends again.
    counts = np.bincount(owner, minlength=count)
    short = np.flatnonzero(counts < 4)
    if len(short):
        more = np.repeat(short, 4 - counts[short])
        last = np.cumsum(counts) - 1
        owner = np.concatenate((owner, more))
        points = np.concatenate((points, points[last[more]]))
        order = np.argsort(owner, kind="stable")
        points, owner = points[order], owner[order]
    rings: NDArray[Any] = shapely.polygons(shapely.linearrings(points, indices=owner))
    return rings


def ways(chains: Sequence[Sequence[Curve]], tolerance: float) -> "NDArray[Any]":
    """The polyline of each chain, an array of shapely lines."""
    import shapely

    points, owner = points_of(chains, tolerance)
    lines: NDArray[Any] = shapely.linestrings(points, indices=owner)
    return lines


def signed_areas(rings: "NDArray[Any]") -> "Floats":
    """The areas of polygons, above 0 for those that run counter-clockwise.

    By the corners about the first one of each: asked which way a ring runs, GEOS looks at its
    highest corner only, and is wrong where that is double but for the last digit.
    """
    import numpy as np
    import shapely

    points, owner = shapely.get_coordinates(rings, return_index=True)
    counts = np.bincount(owner, minlength=len(rings))
    points -= points[np.repeat(np.cumsum(counts) - counts, counts)]
    (x0, y0), (x1, y1) = points[:-1].T, points[1:].T
    # From the last corner of a ring to the first of the next one, which is its own 0, 0.
    return np.bincount(owner[:-1], (x0 * y1 - x1 * y0) / 2, len(rings)).astype(np.float64)


def invalid(rings: "NDArray[Any]") -> list[int]:
    """The numbers of the rings that meet themselves, ascending."""
    import numpy as np
    import shapely

    return np.flatnonzero(~shapely.is_valid(rings)).tolist()


def valid(rings: "NDArray[Any]", bad: Sequence[int]) -> "NDArray[Any]":
    """The rings, those that are `bad` taken apart."""
    import shapely

    if not bad:
        return rings
    found = rings.copy()
    found[bad] = shapely.make_valid(rings[bad])
    return found


def points_of(chains: Sequence[Sequence[Curve]], tolerance: float) -> Drawn:
    """Points of all chains, and the chain of each."""
    import numpy as np

    from beamcam.geometry.polylines import polylines

    drawn = polylines([curve for chain in chains for curve in chain], tolerance)
    chain_of = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    return drawn.points, np.repeat(chain_of, np.diff(drawn.begins))


# --- shape ----------------------------------------------------------------------------------------

# A contour that one process follows.


class Shape(Struct, frozen=True, gc=False):
    """A contour that one process follows, and where it lies among the cut ones.

    The part is the set of points that an odd number of closed cut contours enclose, contours
    that are drawn twice counted once. So a contour of even depth is an outline, whose waste lies
    outside of it, and one of odd depth a hole, whose waste lies inside.
    """

    process: TorchProcess
    curves: tuple[Curve, ...]
    closed: bool
    features: tuple[int, ...]  #: ascending; `assign_process.OUTLINE` may be among them
    source: Source
    depth: int = 0  #: nesting depth: number of cut contours around it
    parent: int = -1  #: the innermost of them, by its index; -1 for none
    look: str = ""  #: key of the settings that it is worked with
    level: int = 0  #: of common cuts: after those of lower levels, on which it begins and ends
    is_begun: bool = False  #: whether it has to begin where it does
    is_small: bool = False  #: a small hole, by the row that it is cut with
    area: float = 0.0  #: inside of a closed cut, mm2, above 0 if it runs counter-clockwise
    joints: tuple[Point, ...] = ()  #: where what is left of other contours begins and ends on it

    @property
    def is_ring(self) -> bool:
        """Whether it has an inside, as an offset needs one."""
        return self.closed and self.area != 0.0

    @property
    def is_hole(self) -> bool:
        return self.depth % 2 == 1


def entity(source: Source) -> str:
    """Name of another entity of the same file in messages: its handle, line or element."""
    if source.where is not None:
        return source.where
    return f"line {source.line}" if source.line is not None else source.file


def curves_of(feature: Hole | Slot, cross: float) -> tuple[Curve, ...]:
    """The closed contour of a hole or a slot, counter-clockwise; of a centre mark its cross."""
    if feature.kind == "mark":
        return cross_at((feature.x, feature.y), cross)
    if isinstance(feature, Hole):
        return (Arc((feature.x, feature.y), feature.diameter / 2, 0.0, 360.0),)
    # Lines joined by corner arcs of the slot's diameter: half circles where it has no height.
    (c, s), u, v = unit_vector(feature.angle), feature.length / 2, feature.height / 2
    arcs = [
        Arc((feature.x + c * x - s * y, feature.y + s * x + c * y), feature.diameter / 2,
            feature.angle + 90.0 * k, 90.0)
        for k, (x, y) in enumerate(((u, v), (-u, v), (-u, -v), (u, -v)))
    ]  # fmt: skip
    curves: list[Curve] = []
    for k, arc in enumerate(arcs):
        curves += [arc] if arc.radius > 0.0 else []
        if (u, v)[k % 2] > 0.0:
            curves.append(Line(arc.end, arcs[(k + 1) % 4].start))
    return tuple(curves)


def cross_at(at: Point, size: float) -> tuple[Line, Line]:
    """The two lines that mark a centre."""
    (x, y), half = at, size / 2
    return Line((x - half, y), (x + half, y)), Line((x, y - half), (x, y + half))


def centres_of(feature: Hole | Slot) -> list[Point]:
    """Drill start points: the centre of a hole, those of the round corners of a slot."""
    if isinstance(feature, Hole):
        return [(feature.x, feature.y)]
    (c, s), points = unit_vector(feature.angle), list[Point]()
    for u, v in product({feature.length / 2, -feature.length / 2},
                        {feature.height / 2, -feature.height / 2}):  # fmt: skip
        points.append((feature.x + c * u - s * v, feature.y + s * u + c * v))
    return sorted(points)


SAME_SIZE = 1e-6  #: mm, that an opening may be below the least by its last digits


class Opening(Struct, frozen=True):
    """A contour that is a circle or a slot, whatever curves draw it."""

    centres: tuple[Point, ...]  #: of a circle one, of a slot those of its round ends
    width: float
    length: float  #: of a circle its diameter


def round_ended(shape: Shape, least: float, tolerance: float) -> Opening | None:
    """A contour as a circle or a slot that is narrower than `least`; None if it is none."""
    lines = [curve for curve in shape.curves if isinstance(curve, Line)]
    along = max(lines, key=lambda line: line.length).tangent(0.0) if lines else (1.0, 0.0)
    (c, s), corners = along, points_of([shape.curves], tolerance / 4)[0].tolist()
    level = [curve.transformed(((c, s, 0.0), (-s, c, 0.0))) for curve in shape.curves]
    x0, y0, x1, y1 = join_boxes([curve.bbox for curve in level]) or (0.0,) * 4
    length, width = x1 - x0, y1 - y0
    if abs(length - width) <= 2 * tolerance:
        length = width = (length + width) / 2
    if width > length or width >= least - SAME_SIZE:
        return None
    centre, middle, reach = (x0 + x1) / 2, (y0 + y1) / 2, (length - width) / 2
    ends = [
        (c * u - s * middle, s * u + c * middle)
        for u in dict.fromkeys((centre - reach, centre + reach))
    ]
    (ex, ey), way = ends[0], (ends[-1][0] - ends[0][0], ends[-1][1] - ends[0][1])
    size = dot(way, way)
    for x, y in (*corners, *(between(a, b, 0.5) for a, b in pairwise(corners))):
        share = dot(way, (x - ex, y - ey)) / size if size else 0.0
        nearest = between(ends[0], ends[-1], min(max(share, 0.0), 1.0))
        if abs(distance((x, y), nearest) - width / 2) > tolerance:
            return None
    return Opening(tuple(ends), width, length)


def with_outline(part: Part) -> Part:
    """A plate that is described by its length and width alone, with its rectangle as a contour."""
    lines = outline_of(part)
    if not lines:
        return part
    return replace(part, features=(*part.features, Contour("v", "outer", lines, part.source)))


def outer_contours(part: Part) -> dict[int, Contour]:
    """The outer contours that are cut, by their indices."""
    return {
        k: one for k, one in enumerate(part.features)
        if isinstance(one, Contour) and one.kind == "outer" and one.process == "cut"
        and one.face in PLATE_FACES
    }  # fmt: skip


def is_plate_contour(one: Contour) -> bool:
    """Whether it is a closed cut of a plate, and not one of a drawing."""
    plain = one.process == "cut" and one.closed and one.face in PLATE_FACES
    return plain and one.layer is None and one.colour is None


def outline_of(part: Part) -> tuple[Line, ...]:
    """The outline of a plate that has no contour of its own: its length and width, and its ends as
    the header has them; nothing for others and drawings.
    """
    if part.measures is not None or outer_contours(part):
        return ()
    (a, d), (b, c) = end_lines(part, "v")
    return Line(a, b), Line(b, c), Line(c, d), Line(d, a)


def reach_of(part: Part) -> Box:
    """The box around all that a part has, of a plate without anything its length and width."""
    box = extent(curve for feature in part.features for curve in reached_curves(feature))
    return box or (0.0, 0.0, part.length, part.profile.height)


def reached_curves(feature: Feature) -> Iterator[Curve]:
    """Curves that reach as far as a feature does."""
    if isinstance(feature, Contour):
        yield from feature.curves
    elif isinstance(feature, Hole):
        yield Arc((feature.x, feature.y), feature.diameter / 2, 0.0, 360.0)
    elif isinstance(feature, Slot):
        c, s = unit_vector(feature.angle)
        for u in (-feature.length / 2, feature.length / 2):
            for v in (-feature.height / 2, feature.height / 2):
                centre = feature.x + c * u - s * v, feature.y + s * u + c * v
                yield Arc(centre, feature.diameter / 2, 0.0, 360.0)


#  ____________       A torch follows whatever is closed: a hole beside the outline would be cut
# |  ______    |      into the sheet there, one in a cut-out into what falls out of it. Both are
# | |  o   |   |  o   mistakes of the file, and nothing says which of its numbers is wrong.
# | |______|   |
# |____________|


def off_plate(part: Part, tolerance: float) -> Iterator[Diagnostic]:
    """An error for each hole, slot and cut-out that lies off the plate.

    A torch follows whatever is closed: such a one would be cut into the sheet beside. One that
    crosses an edge is refused where contours that cross are; one in a larger opening is told by
    `planning.within`. Drawings have outlines alone, which nest.
    """
    import shapely

    openings = [
        f for f in part.features
        if (isinstance(f, Contour) and f.kind == "inner" and is_plate_contour(f))
        or (isinstance(f, Hole | Slot) and f.kind != "mark" and f.face in PLATE_FACES)
    ]  # fmt: skip
    if not openings:
        return
    around: list[Curves] = [one.curves for one in outer_contours(part).values()]
    around += [own] if (own := outline_of(part)) else []
    chains = [*around, *(f.curves if isinstance(f, Contour) else curves_of(f, 0.0)
                         for f in openings)]  # fmt: skip
    rings = outlines(chains, tolerance / 4)
    rings = valid(rings, invalid(rings))
    plate, holes = rings[: len(around)], rings[len(around) :]
    on_plate = {*shapely.STRtree(plate).query(holes, predicate="intersects")[0].tolist()}
    for k, opening in enumerate(openings):
        if k not in on_plate:
            yield rules.OFF.at(opening.source, what=description(opening))
