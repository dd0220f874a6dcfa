"""Faults of the cuts of a bar whose pieces are not its parts, and of outlines that no cuts give."""

from collections.abc import Sequence
from itertools import pairwise
from operator import attrgetter

from beamcam.checks import rules
from beamcam.checks.bars.pieces import OUTLINE_TOLERANCE, Ends, RequiredEnd
from beamcam.checks.bars.stations import Cut, wall_between
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line, Point
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Saw
from beamcam.model.part import Contour, Face, Part, Profile


def off_outline(contour: Contour, part: Part, ends: Ends) -> Point | None:
    """The first point of an outer contour off the sawn stock; None if there is none.

    Every point of it has to lie on a long edge or an end, and every corner of the sawn face has
    to be a point of it. A skew cut leaves a plate's end skew through its thickness, and either
    surface may be drawn. Its area is that of the sawn face, but for a strip along the outline: one
    that runs across the face from corner to corner encloses less.
    """
    width = part.profile.face_width(contour.face)
    points = [c.start for c in contour.curves]
    points += [c.point(0.5) for c in contour.curves if not isinstance(c, Line)]
    fixed = None
    if ends[0].square and ends[1].square:
        fixed = [_span(end, contour.face, part.profile, 0.0) for end in ends]
    for x, y in points:
        spans = fixed or [_span(end, contour.face, part.profile, y) for end in ends]
        on_edge = min(abs(y), abs(y - width)) <= OUTLINE_TOLERANCE
        at_end = x <= spans[0][1] or x >= spans[1][0]
        if not (spans[0][0] <= x <= spans[1][1]) or not (on_edge or at_end):
            return x, y
    for corner in (0.0, width):
        for end in ends:
            least, greatest = _span(end, contour.face, part.profile, corner)
            if not any(
                least <= x <= greatest and abs(y - corner) <= OUTLINE_TOLERANCE for x, y in points
            ):
                return (least + greatest) / 2, corner
    starts = [c.start for c in contour.curves]
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise([*starts, starts[0]])) / 2
    first, last = (_span(end, contour.face, part.profile, width / 2) for end in ends)
    strip = 2 * OUTLINE_TOLERANCE * (last[1] - first[0])
    least, most = width * (last[0] - first[1]) - strip, width * (last[1] - first[0]) + strip
    if not least <= abs(area) <= most:
        return points[0]
    return None


def _span(end: RequiredEnd, face: Face, profile: Profile, q: float) -> tuple[float, float]:
    """Minimum and maximum x at which an end may be drawn on a face, at its coordinate q."""
    surfaces = wall_between(profile, face)
    if profile.code in ("SO", "RO", "RU") and face in ("v", "h"):
        surfaces = 0.0, profile.width
    xs = end.at_wall(face, q, surfaces)
    return min(xs) - OUTLINE_TOLERANCE, max(xs) + OUTLINE_TOLERANCE


# --- cut faults -----------------------------------------------------------------------------------

# Faults in the cuts of a bar whose pieces are not its parts.
#
#     | start cut |# part 1 ######/ end cut | parting cut |# part 2 ####| parting cut
#
# A square start is made by the cut that parts it from what lies before it, a skew end has a cut of
# its own and a square one behind it that removes the wedge. The blade is always on the waste side.


COMMON_DEG = 0.01  #: ends that differ by no more may share a cut
SQUARE = RequiredEnd(1, 0.0, 0.0, 0.0)
NEAR = 60.0  #: mm; a cut this near to where it should be is taken for it, in the wrong place


class CutFaults:
    """Parts laid on the bar by the cuts that come nearest to theirs: `starts` and `diagnostics`."""

    def __init__(self, cuts: Sequence[Cut], machine: Machine, saw: Saw, name: str) -> None:
        self.machine, self.saw, self.name = machine, saw, name
        self.left = sorted(cuts, key=attrgetter("x", "line"))
        self.tolerance = machine.format.resolution + 1e-6
        self.angle_tolerance = 0.5 * 10.0**-machine.format.angle_decimals + 1e-6
        self.starts: list[float] = []
        self.diagnostics: list[Diagnostic] = []

    def place(self, parts: Sequence[Part], ends: Sequence[Ends]) -> None:
        """Find every part's cuts, in the order given; what is left over is too much."""
        saw = self.saw
        begin: float | None = None  #: where the cut before lets the next part begin
        shared = False  #: whether that cut made the next start, skew as it may be
        for index, (part, (first, last)) in enumerate(zip(parts, ends, strict=True)):
            following = ends[index + 1][0] if index + 1 < len(parts) else None
            start, height = begin, part.profile.height
            if start is None or not (first.square or shared):
                start = self._start(part, ends[index], begin)
                self._take(first, start + first.blade(saw, height), part)
            self.starts.append(start)
            end, shared = start + part.length, False
            if last.square:
                begin = self._take_square(last, end + saw.kerf / 2, part)
                continue
            cut = self._take(last, start + last.blade(saw, height), part)
            # Where the square cut may stand that removes the wedge, the likeliest first: never
            # before the middle of the mitre.
            behind, squares = [end + last.kerf(saw) / 2], self._places(SQUARE)
            if following is not None and following.square:
                # It makes the next start too, so it says where that is.
                behind += [x for x in squares if x >= end + saw.kerf / 2 - self.tolerance][:1]
            at = next((x for x in behind if self._is_there(x, squares)), None)
            if at is None and cut is not None:
                if following is None:
                    break  # the bar ends with the part, and its wedge falls off
                apart = abs(last.web - following.web), abs(last.flange - following.flange)
                if saw.common_cuts and max(apart) <= COMMON_DEG:
                    begin, shared = cut.x - saw.x - following.blade(saw, height), True
                    continue
            begin = self._take_square(SQUARE, behind[0] if at is None else at, part)
        for extra in self.left:
            angle, source = _shown(extra.angle, extra.tilt), Source(self.name, extra.line)
            self.diagnostics.append(rules.CUT_EXTRA.at(source, angle=angle, x=f"{extra.x:g}"))

    def _take_square(self, end: RequiredEnd, bar_x: float, part: Part) -> float:
        """Where the next part begins behind a square cut."""
        cut = self._take(end, bar_x, part)
        return (cut.x - self.saw.x if cut else bar_x) + self.saw.kerf / 2

    def _like(self, end: RequiredEnd, cuts: Sequence[Cut]) -> list[Cut]:
        """Those of the cuts that have an end's angles."""
        angle, tilt = end.saw_angles(self.saw)
        limit = self.angle_tolerance
        return [c for c in cuts if abs(c.angle - angle) <= limit and abs(c.tilt - tilt) <= limit]

    def _places(self, end: RequiredEnd) -> list[float]:
        """Bar x of the cuts that are left and have an end's angles."""
        return [c.x - self.saw.x for c in self._like(end, self.left)]

    def _is_there(self, bar_x: float, places: Sequence[float]) -> bool:
        return any(abs(place - bar_x) <= self.tolerance for place in places)

    def _start(self, part: Part, ends: Ends, begin: float | None) -> float:
        """The start of a part: where its first cut fits one at its other end, if there is any."""
        at, reach = (e.blade(self.saw, part.profile.height) for e in ends)
        starts = [x - at for x in self._places(ends[0])]
        last = self._places(ends[1])
        for start in starts:
            if self._is_there(start + reach, last):
                return start
        starts += [place - reach for place in last]
        if begin is None:
            begin = self.machine.layout.front_trim if self.machine.layout is not None else 0.0
        return min(starts, key=lambda start: abs(start - begin), default=begin)

    def _take(self, end: RequiredEnd, bar_x: float, part: Part) -> Cut | None:
        """The cut at `bar_x`, taken from those that are left; what is wrong with it is reported."""
        x = bar_x + self.saw.x
        here = [c for c in self.left if abs(c.x - x) <= self.tolerance]
        best = min(self._like(end, here), key=lambda c: abs(c.x - x), default=None)
        if best is None:
            names = {"end": end.name, "mark": part.mark}
            angle, tilt = end.saw_angles(self.saw)
            near = [c for c in self._like(end, self.left) if abs(c.x - x) <= NEAR]
            if here:
                best = min(here, key=lambda c: abs(c.angle - angle))
                found, expected = _shown(best.angle, best.tilt), _shown(angle, tilt)
                rule = rules.CUT_ANGLE
            elif near:
                best = min(near, key=lambda c: abs(c.x - x))
                rule, found, expected = rules.CUT_PLACE, f"{best.x:.6g}", f"{x:.6g}"
            else:
                source = part.cut_source("web" if end.web else "flange", end.name)
                names |= {"angle": _shown(angle, tilt), "x": f"{x:.6g}"}
                self.diagnostics.append(rules.CUT_MISSING.at(source, **names))
                return None
            source = Source(self.name, best.line)
            self.diagnostics.append(rule.at(source, found=found, expected=expected, **names))
        self.left.remove(best)
        return best


def _shown(angle: float, tilt: float) -> str:
    return f"{angle:g}" if not tilt else f"{angle:g}, tilted {tilt:g}"
