"""Lines and arcs in the numbers that are written, those of all chains at once.

A controller sees ends and centre after they were rounded, and checks them against each other. So
the centre is solved again from the rounded ends; where that leaves the controller's limit the arc
is split, and where nothing helps it becomes lines. Nothing is ever written that would turn the
other way round or the long way.
"""

from collections.abc import Callable, Iterator, Sequence
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import CurveTable, table_of, unit_vectors
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line
from beamcam.geometry.plane import Point, cross, dot
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed

#: A number as near to the middle of two steps, in steps, is rounded by its exact decimals.
DOUBT = 1e-5


class Numbers(Struct, frozen=True):
    """Number format of the controller, and what it accepts."""

    decimals: int
    angle_decimals: int
    tolerance: float  #: left for chords that replace an arc
    arc_limit: float  #: max difference of the radii at both ends
    min_radius: float
    max_radius: float

    @property
    def step(self) -> float:
        """The smallest length that is written."""
        return 10.0**-self.decimals

    def at(self, point: Point) -> Point:
        """A point as it is written; never -0."""
        d = self.decimals
        return round(point[0], d) + 0.0, round(point[1], d) + 0.0

    def rounded(self, values: Floats) -> Floats:
        """Numbers as they are written, each as `at` has it."""
        scaled = values * 10.0**self.decimals
        whole = np.rint(scaled)
        rounded: Floats = whole / 10.0**self.decimals + 0.0
        # Scaled to steps a number may come to lie on the other side of a middle.
        for place in zip(*np.nonzero(np.abs(scaled - whole) > 0.5 - DOUBT), strict=True):
            rounded[place] = round(float(values[place]), self.decimals) + 0.0
        return rounded


#: Above this sweep an arc is written as two, so that no controller can take the other way round.
MAX_SWEEP_DEG = 180.0
SWEEP_SLACK_DEG = 1e-9

#: How far the written centre may lie beside the bisector of the written chord, by the radius;
#: CODESYS mends a tenth and drives a line beyond.
BISECTOR_SHARE = 0.02

#: Below this sweep the radius is kept and above it the sweep, which is what each depends on least.
KEEP_SWEEP_DEG = 90.0

#: Of an arc; chords of a circle of a kilometre are then 0.01 mm long.
MAX_SPLITS = 30


class ChainMoves(Struct, frozen=True):
    """The moves along a chain, and the written place where they begin."""

    start: Point
    moves: list[Movement]
    curve: list[int]  #: of each move, the number of its curve in the chain


#: The moves along a curve that is neither a line nor an arc, from a written place.
ByWord = Callable[[Point, Curve], list[Movement]]


def paths_along(
    chains: Sequence[Sequence[Curve]], numbers: Numbers, by_word: ByWord
) -> Iterator[ChainMoves]:
    """The moves along each chain, none of them empty, in their order.

    A curve is followed from where the one before it was written to end; moves of no length are
    left out. Arcs are at most half a circle, and lines where they are too flat to differ from one,
    or too small or too large for the controller.
    """
    table = table_of(tuple([curve for chain in chains for curve in chain]))
    if not table.curves:
        return
    lasts = np.cumsum([len(chain) for chain in chains])
    firsts = lasts - [len(chain) for chain in chains]
    written = numbers.rounded(table.ends)
    follows = np.ones(len(table.curves), dtype=bool)
    follows[firsts] = False
    after = np.flatnonzero(follows)
    written[after, :2] = written[after - 1, 2:]
    owner, begin, moves = _moves(table, written, numbers)
    for k in table.free():
        own = by_word((float(written[k, 0]), float(written[k, 1])), table.curves[k])
        owner = np.concatenate((owner, np.full(len(own), k)))
        begin = np.concatenate((begin, np.arange(len(own))))
        moves += own
    order = np.lexsort((begin, owner))
    moves = [moves[k] for k in order.tolist()]
    owner = owner[order]
    bounds = np.searchsorted(owner, np.concatenate((firsts, lasts[-1:]))).tolist()
    for k, (x, y) in enumerate(written[firsts, :2].tolist()):
        a, b = bounds[k], bounds[k + 1]
        yield ChainMoves((x, y), moves[a:b], (owner[a:b] - firsts[k]).tolist())


def _moves(
    table: CurveTable, written: Floats, numbers: Numbers
) -> tuple[Counts, Floats, list[Movement]]:
    """The moves along lines and arcs: of each its curve, how far on it, and itself."""
    lines, arcs = table.where(Line), table.where(Arc)
    lines = lines[_is_move(written[lines])]
    pending = _Arcs(arcs, np.zeros(len(arcs)), table.arcs, written[arcs])
    flat = [(lines, np.zeros(len(lines)), written[lines, 2:])]
    owner: list[Counts] = []
    begin: list[Floats] = []
    moves: list[Movement] = []
    for splits in range(MAX_SPLITS + 1):
        pending = pending.take(_is_move(pending.ends) | pending.is_wide())
        if not len(pending.owner):
            break
        if splits == MAX_SPLITS:
            raise AssertionError("an arc that halving does not make flat")
        radius, sweep = pending.arcs[:, 2], np.abs(pending.arcs[:, 4])
        sagitta = radius * (1 - np.cos(np.radians(sweep) / 2))
        short = ~pending.is_wide()
        is_flat = short & (sagitta < numbers.step / 2)
        good = short & ~is_flat & (numbers.min_radius <= radius) & (radius <= numbers.max_radius)
        offset = np.zeros((len(radius), 2))
        which = np.flatnonzero(good)
        offset[which], good[which] = _centres(pending.arcs[which], pending.ends[which], numbers)
        straight = is_flat | (short & ~good & (sagitta <= numbers.tolerance))
        chords = pending.take(straight)
        flat.append((chords.owner, chords.begin, chords.ends[:, 2:]))
        done = pending.take(good)
        owner.append(done.owner)
        begin.append(done.begin)
        columns = (*done.ends[:, 2:].T.tolist(), *offset[good].T.tolist())
        moves += map(ArcFeed, *columns, (done.arcs[:, 4] < 0).tolist())
        pending = pending.take(~(good | straight)).halves(numbers)
    for which, at, end in flat:
        owner.append(which)
        begin.append(at)
        moves += map(Feed, *end.T.tolist())
    return np.concatenate(owner), np.concatenate(begin), moves


def _is_move(ends: Floats) -> Flags:
    return np.asarray((ends[:, :2] != ends[:, 2:]).any(axis=1))


class _Arcs(Struct, frozen=True):
    """Arcs that are to be written, or parts of them."""

    owner: Counts  #: curve that each is of
    begin: Floats  #: angle of the curve before it
    arcs: Floats  #: rows as `CurveTable.arcs`, (n, 5)
    ends: Floats  #: written start and end, (n, 4)

    def take(self, rows: Flags) -> "_Arcs":
        return _Arcs(self.owner[rows], self.begin[rows], self.arcs[rows], self.ends[rows])

    def is_wide(self) -> Flags:
        """Which are more than half a circle; a whole one ends where it begins."""
        return np.abs(self.arcs[:, 4]) > MAX_SWEEP_DEG + SWEEP_SLACK_DEG

    def halves(self, numbers: Numbers) -> "_Arcs":
        """Both halves of each."""
        first, second = self.arcs.copy(), self.arcs.copy()
        half = self.arcs[:, 4] / 2
        first[:, 4] = half
        second[:, 3] += half
        second[:, 4] = self.arcs[:, 4] - half
        middle = numbers.rounded(_points(self.arcs, self.arcs[:, 3] + half))
        turned = self.begin + np.abs(half)
        return _Arcs(
            np.concatenate((self.owner, self.owner)),
            np.concatenate((self.begin, turned)),
            np.concatenate((first, second)),
            np.block([[self.ends[:, :2], middle], [middle, self.ends[:, 2:]]]),
        )


def _points(arcs: Floats, angles_deg: Floats) -> Floats:
    return arcs[:, :2] + arcs[:, 2:3] * unit_vectors(angles_deg)


def _centres(arcs: Floats, ends: Floats, numbers: Numbers) -> tuple[Floats, Flags]:
    """The way from each written start to the centre, and whether the arc is still the same."""
    radius, sweep = arcs[:, 2], np.abs(arcs[:, 4])
    step = ends[:, 2:] - ends[:, :2]
    chord = np.hypot(step[:, 0], step[:, 1])
    half = chord / 2
    keeps_radius = sweep < KEEP_SWEEP_DEG
    reaches = ~keeps_radius | (radius >= half)
    square = np.where(keeps_radius & reaches, radius * radius - half * half, 0.0)
    by_sweep = half / np.tan(np.radians(np.maximum(sweep, KEEP_SWEEP_DEG)) / 2)
    height = np.where(keeps_radius, np.sqrt(square), by_sweep)
    side = np.where(arcs[:, 4] > 0, 1.0, -1.0)
    along = step / chord[:, None]
    across = (side * height)[:, None] * np.column_stack((-along[:, 1], along[:, 0]))
    offset = numbers.rounded(step / 2 + across)
    # Which arcs a controller takes for what they are.
    start, end = ends[:, :2], ends[:, 2:]
    centre = start + offset
    near, far = np.hypot(*offset.T), np.hypot(*(end - centre).T)
    same = reaches & (np.abs(near - far) <= numbers.arc_limit) & (near >= numbers.min_radius)
    aside = np.abs(np.sum((centre - (start + end) / 2) * along, axis=1))
    same &= aside <= BISECTOR_SHARE * near
    first, last = (np.arctan2(p[:, 1], p[:, 0]) for p in (start - centre, end - centre))
    half_rad = first + side * (side * (last - first) % (2 * np.pi)) / 2
    middle = centre + near[:, None] * np.column_stack((np.cos(half_rad), np.sin(half_rad)))
    drawn = _points(arcs, arcs[:, 3] + 0.5 * arcs[:, 4])
    return offset, same & (np.hypot(*(middle - drawn).T) <= 3 * numbers.step)


# --- curve words ----------------------------------------------------------------------------------

# Parabolas and ellipses in the numbers that are written, where the controller has words for them.
#
# A controller sees ends and centre after they were rounded, and solves the curve from these.
# Nothing is ever written that it would take for another curve.


#: An ellipse rounder than this is fitted with arcs, since its axes cannot be told apart.
ROUND_RATIO = 0.999


def ellipse_feeds(start: Point, ellipse: EllipseArc, numbers: Numbers) -> list[Movement] | None:
    """The moves along an ellipse by its own word; None where that would be another ellipse.

    It is cut at the ends of its axes, for between them both end points determine it best. The
    axes follow from the rounded ends, as CODESYS solves them: x^2 / a^2 + y^2 / b^2 = 1 twice.
    """
    moves: list[Movement] = []
    here = start
    for piece in _quarters(ellipse):
        end = numbers.at(piece.end)
        if end == here:
            continue
        move = _written_ellipse(here, end, piece, numbers)
        if move is None:
            return None
        moves.append(move)
        here = end
    return moves


def _quarters(ellipse: EllipseArc) -> Iterator[EllipseArc]:
    """Pieces that pass no end of an axis."""
    sign = 1.0 if ellipse.sweep_deg > 0 else -1.0
    done, rest = 0.0, ellipse
    total = abs(ellipse.sweep_deg)
    first = (-sign * ellipse.start_deg) % 90.0 or 90.0
    at = first
    while at < total - 1e-9:
        left, rest = rest.split((at - done) / (total - done))
        yield left
        done, at = at, at + 90.0
    yield rest


def _written_ellipse(
    start: Point, end: Point, piece: EllipseArc, numbers: Numbers
) -> EllipseFeed | None:
    i, j = numbers.at((piece.centre[0] - start[0], piece.centre[1] - start[1]))
    angle = round(degrees(atan2(piece.axis[1], piece.axis[0])), numbers.angle_decimals) + 0.0
    ratio = round(piece.ratio, 6)
    centre = (start[0] + i, start[1] + j)
    c, s = cos(radians(angle)), sin(radians(angle))

    def local(p: Point) -> Point:
        x, y = p[0] - centre[0], p[1] - centre[1]
        return c * x + s * y, c * y - s * x

    (x1, y1), (x2, y2) = local(start), local(end)
    det = x1 * x1 * y2 * y2 - x2 * x2 * y1 * y1
    if abs(det) < 1e-9 * piece.major**2 * piece.minor**2:
        return None
    over_a2, over_b2 = (y2 * y2 - y1 * y1) / det, (x1 * x1 - x2 * x2) / det
    if over_a2 <= 0.0 or over_b2 <= over_a2:
        return None
    for share in (0.25, 0.5, 0.75):
        x, y = local(piece.point(share))
        size = sqrt(over_a2 * x * x + over_b2 * y * y)
        if abs(size - 1.0) * hypot(x, y) > 4 * numbers.step:
            return None
    return EllipseFeed(end[0], end[1], i, j, angle, ratio, piece.sweep_deg < 0)


def parabola_feed(start: Point, curve: Bezier, numbers: Numbers) -> list[Movement]:
    """The move along a Bezier curve of degree two; a line where it is too flat to differ.

    Its vertex, where the tangent is parallel to the chord, is its point at t = 1/2.
    """
    (x0, y0), (x1, y1), (x2, y2) = curve.points
    end = numbers.at(curve.end)
    vertex = (x0 / 4 + x1 / 2 + x2 / 4, y0 / 4 + y1 / 2 + y2 / 4)
    if end == start:
        return []
    chord = (x2 - x0, y2 - y0)
    if abs(cross(chord, (vertex[0] - x0, vertex[1] - y0))) < numbers.step / 2 * hypot(*chord):
        return [Feed(*end)]
    i, j = numbers.at((vertex[0] - start[0], vertex[1] - start[1]))
    drawn = (end[0] - start[0], end[1] - start[1])
    if abs(cross(drawn, (i, j))) < numbers.step / 4 * hypot(*drawn):
        return [Feed(*end)]  # rounding took the vertex onto the chord, where no parabola has it
    return [ParabolaFeed(end[0], end[1], i, j)]


def is_parabola(curve: Bezier) -> bool:
    """Whether a curve is a parabola that its chord sees from the side.

    A control point that does not lie over the chord makes the curve turn back on it, where the
    word of the controller says less than the curve is.
    """
    if curve.degree != 2 or curve.weights is not None or curve.start == curve.end:
        return False
    (x0, y0), (x1, y1), (x2, y2) = curve.points
    leg, chord = (x1 - x0, y1 - y0), (x2 - x0, y2 - y0)
    size = hypot(*chord) ** 2
    return 0.0 <= dot(leg, chord) / size <= 1.0 or abs(cross(leg, chord)) > 1e-6 * size
