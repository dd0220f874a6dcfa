"""What a program makes against what its parts need: everything once, in its place, nothing else."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from math import floor, isnan, pi, radians, tan
from typing import NamedTuple

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Drill, Machine, Saw
from beamcam.model.part import Hole, Part, Profile
from beamcam.verify import rules
from beamcam.verify.made import Bore, Cut, Made
from beamcam.verify.meaning import Meaning
from beamcam.verify.need import HOLE_TOOLS, FeatureRef, ends_of, fit, holes_of, tool_for, unsawn
from beamcam.verify.placing import NEAR, Placing
from beamcam.verify.stations import Choice, stroke_values


class Wanted(NamedTuple):
    """One hole that a part needs."""

    part: int  #: index on the bar
    hole: Hole
    x: float  #: machine X


def compare(
    made: Made,
    parts: Sequence[Part],
    machine: Machine,
    meaning: Meaning,
    choices: dict[int, Choice],
    skipped: Collection[FeatureRef] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Every difference between a program and its parts, which lie on the bar in the order given.

    `skipped` names features that the program may leave out. Raises TypeError for a machine
    without saw and drill.
    """
    saw, drill = machine.saw, machine.drill
    if saw is None or drill is None:
        raise TypeError(f"{machine.name} has no saw and drill")
    said = [*_section(made, parts[0].profile, machine, name)]
    placing = Placing(made.cuts, machine, saw, name)
    placing.place(parts)
    said += placing.said
    said += _not_made(parts, saw, skipped)
    wanted = [
        Wanted(p, hole, drill.x + placing.starts[p] + hole.x)
        for p, part in enumerate(parts)
        for hole in holes_of(part, p, machine, skipped)
    ]
    matches = list(_Matching(made.bores, wanted, parts, machine, drill, name).run(said))
    fine: set[object] = set()  # most holes of a part are like another one of it
    for match in matches:
        (part, hole, _), bore, size = match
        alike = (part, hole.face, hole.kind, hole.diameter, hole.depth, size, *bore[4:])
        if alike in fine:
            continue
        found = [*_tool(match, parts, machine, name)]
        if not errors_in(found):  # another tool has another depth and feed, of course
            found += _depth(match, parts, machine, drill, choices, name)
            if meaning.feeds:
                found += _feed(bore, parts[part].grade, drill, name)
        if found:
            said += found
        else:
            fine.add(alike)
    if meaning.feeds:
        said += _saw_feeds(made.cuts, saw, name)
    if machine.layout is not None and machine.layout.order == "drill-saw":
        said += _after_its_cut(matches, made, placing.last_cut, name)
    return tuple(said)


def _section(made: Made, profile: Profile, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """What the program says about the bar, against the parts' profile."""
    expected = {
        "height": profile.height,
        "width": profile.width,
        "section": float(machine.sections.get(profile.code, -1)),
    }
    for field, value in made.section:
        if not isnan(value) and abs(value - expected[field]) > 0.75 * machine.format.resolution:
            yield rules.SECTION.at(
                Source(name), what=field, found=f"{value:g}", expected=f"{expected[field]:g}"
            )


def _not_made(
    parts: Sequence[Part], saw: Saw, skipped: Collection[FeatureRef]
) -> Iterator[Diagnostic]:
    """The features that no cut and no stroke makes."""
    for p, part in enumerate(parts):
        ends = ends_of(part, saw)
        for f, feature in enumerate(part.features):
            found = None if (p, f) in skipped else unsawn(feature, part, ends)
            if found is None:
                continue
            what, off = found
            if off is not None:
                yield rules.OUTLINE.at(
                    feature.source, face=getattr(feature, "face", ""), mark=part.mark,
                    x=f"{off[0]:g}", y=f"{off[1]:g}",
                )  # fmt: skip
            else:
                yield rules.NOT_MADE.at(feature.source, found=f"the {what}", mark=part.mark)


class Match(NamedTuple):
    """A hole that is wanted and the bore that makes it."""

    wanted: Wanted
    bore: Bore
    size: float  #: the hole's diameter, of two that are drilled at once the greater


class _Matching:
    """Bores and holes, each to at most one of the others.

    Holes wait in pockets of 1 mm of X by face, so that a bore looks at two pockets at most.
    """

    def __init__(
        self, bores: Sequence[Bore], wanted: Sequence[Wanted], parts: Sequence[Part],
        machine: Machine, drill: Drill, name: str,
    ) -> None:  # fmt: skip
        self.bores, self.wanted, self.parts, self.name = bores, wanted, parts, name
        self.drill = drill
        self.x_tolerance = machine.format.resolution + 1e-6  # of the start's cut, and its own
        self.y_tolerance = 0.75 * machine.format.resolution + 1e-6
        self.pockets: dict[tuple[str, int], list[Wanted]] = {}
        for want in wanted:
            self.pockets.setdefault((want.hole.face, floor(want.x)), []).append(want)

    def run(self, said: list[Diagnostic]) -> Iterator[Match]:
        """The matches; what lies elsewhere, is missing or too much goes to `said`."""
        pairs: dict[tuple[int, int], list[Bore]] = {}
        for bore in self.bores:
            pairs.setdefault((bore.line, bore.spindle), []).append(bore)
        astray: list[Bore] = []
        for group in pairs.values():
            reach = self.drill.merge_tolerance if len(group) > 1 else 0.0
            found = [self._take(bore, reach) for bore in group]
            holes = [w for w in found if w is not None]
            size = max((w.hole.diameter for w in holes), default=0.0)
            for bore, want in zip(group, found, strict=True):
                if want is None:
                    astray.append(bore)
                    continue
                if not self._between(bore, holes):
                    said.append(self._elsewhere(bore, want))
                yield Match(want, bore, size)
        for bore in astray:
            want = self._nearest(bore)
            if want is None:
                said.append(
                    rules.HOLE_EXTRA.at(
                        Source(self.name, bore.line),
                        diameter=f"{bore.diameter:g}",
                        face=bore.face,
                        x=f"{bore.x:g}",
                        y=f"{bore.y:g}",
                    )
                )
            else:
                self._remove(want)
                said.append(self._elsewhere(bore, want))
                yield Match(want, bore, want.hole.diameter)
        for left in self.pockets.values():
            for want in left:
                hole = want.hole
                said.append(
                    rules.HOLE_MISSING.at(
                        hole.source,
                        diameter=f"{hole.diameter:g}",
                        face=hole.face,
                        mark=self.parts[want.part].mark,
                        x=f"{hole.x:g}",
                        y=f"{hole.y:g}",
                        machine_x=f"{want.x:g}",
                    )
                )

    def _take(self, bore: Bore, reach: float) -> Wanted | None:
        """The nearest hole within reach of a bore, of those that are left; it is taken."""
        x_reach, y_reach = reach + self.x_tolerance, reach + self.y_tolerance
        best: Wanted | None = None
        distance = x_reach + y_reach
        pocket = floor(bore.x - x_reach)
        for key in {pocket, floor(bore.x + x_reach)}:
            for want in self.pockets.get((bore.face, key), ()):
                dx, dy = abs(want.x - bore.x), abs(want.hole.y - bore.y)
                if dx <= x_reach and dy <= y_reach and dx + dy <= distance:
                    if best is not None and dx + dy == distance and self._worse(want, best, bore):
                        continue
                    best, distance = want, dx + dy
        if best is not None:
            self._remove(best)
        return best

    @staticmethod
    def _worse(want: Wanted, best: Wanted, bore: Bore) -> bool:
        """Of two holes in one place the one of the tool's diameter is meant."""
        return abs(want.hole.diameter - bore.diameter) >= abs(best.hole.diameter - bore.diameter)

    def _remove(self, want: Wanted) -> None:
        self.pockets[want.hole.face, floor(want.x)].remove(want)

    def _between(self, bore: Bore, holes: Sequence[Wanted]) -> bool:
        """Whether a stroke lies on its hole, or between the two that it makes at once."""
        xs, ys = [w.x for w in holes], [w.hole.y for w in holes]
        return (
            min(xs) - self.x_tolerance <= bore.x <= max(xs) + self.x_tolerance
            and min(ys) - self.y_tolerance <= bore.y <= max(ys) + self.y_tolerance
        )

    def _nearest(self, bore: Bore) -> Wanted | None:
        """The hole of its face that a bore may have been meant for."""
        near = [
            (abs(w.x - bore.x) + abs(w.hole.y - bore.y), i, w)
            for (face, _), left in self.pockets.items()
            if face == bore.face
            for i, w in enumerate(left)
            if abs(w.x - bore.x) <= NEAR and abs(w.hole.y - bore.y) <= NEAR
        ]
        return min(near)[2] if near else None

    def _elsewhere(self, bore: Bore, want: Wanted) -> Diagnostic:
        hole = want.hole
        return rules.HOLE_PLACE.at(
            Source(self.name, bore.line), diameter=f"{hole.diameter:g}", face=hole.face,
            mark=self.parts[want.part].mark, found_x=f"{hole.x + bore.x - want.x:.6g}",
            found_y=f"{bore.y:.6g}", x=f"{hole.x:g}", y=f"{hole.y:g}",
        )  # fmt: skip


def _described(match: Match, parts: Sequence[Part]) -> dict[str, object]:
    """How messages name a hole."""
    part, hole, _ = match.wanted
    return {
        "diameter": f"{hole.diameter:g}", "face": hole.face, "mark": parts[part].mark,
        "x": f"{hole.x:g}", "y": f"{hole.y:g}",
    }  # fmt: skip


def _tool(match: Match, parts: Sequence[Part], machine: Machine, name: str) -> Iterator[Diagnostic]:
    """What is wrong with the tool that makes a hole."""
    (_, hole, _), bore, size = match
    described = _described(match, parts)
    place = Source(name, bore.line)
    own = tool_for(hole if size == hole.diameter else replace(hole, diameter=size), machine)
    limits = fit(size, machine)
    found = f"a drill {bore.diameter:g}"
    if hole.kind not in HOLE_TOOLS or limits is None or own is None:
        yield rules.TOOL.at(place, found=found, expected="another tool, or none", **described)
    elif not limits[0] - 1e-6 <= bore.diameter <= limits[1] + 1e-6:
        yield rules.TOOL.at(place, found=found, expected=f"a drill {own:g}", **described)
    elif not any(bore.diameter in tools.sizes for tools in machine.tools):
        expected = f"a drill {own:g}, the shop has none of that size"
        yield rules.TOOL.at(place, found=found, expected=expected, **described)
    elif bore.diameter != own:
        yield rules.TOOL_NEARER.at(
            place, found=f"{bore.diameter:g}", expected=f"{own:g}", **described
        )


def _depth(
    match: Match, parts: Sequence[Part], machine: Machine, drill: Drill,
    choices: dict[int, Choice], name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What is wrong with the depth of a hole."""
    (part, hole, _), bore, _ = match
    described = _described(match, parts)
    place = Source(name, bore.line)
    tip = bore.diameter / 2 / tan(radians(_point_deg(bore.diameter, machine)) / 2)
    profile = parts[part].profile
    thickness = profile.thickness(hole.face)
    full = bore.tip_depth - tip
    slack = machine.format.resolution + 1e-6
    found = f"{full:.3f}"
    if hole.depth is not None:
        if abs(full - hole.depth) > slack:
            yield rules.DEPTH.at(place, found=found, expected=f"{hole.depth:g}", **described)
        return
    spindle = next(s for s in machine.spindles if s.face == hole.face)
    values = stroke_values(machine, profile, hole.face)
    values |= {"depth": thickness + drill.breakthrough, "tip": tip, "y": hole.y}
    station = next(s for s in choices[bore.spindle].stations if s.face == hole.face)
    deepest = station.tip_depth(spindle.stroke.bottom(values)) - tip
    if full < thickness - slack:
        expected = f"at least the {thickness:g} mm of the material"
        yield rules.DEPTH.at(place, found=found, expected=expected, **described)
    elif full > deepest + slack:
        yield rules.DEPTH.at(place, found=found, expected=f"at most {deepest:.3f}", **described)


def _point_deg(diameter: float, machine: Machine) -> float:
    """Angle of the point of the shop's drill of a diameter."""
    for tools in machine.tools:
        if tools.kind == "drill" and diameter in tools.sizes:
            return tools.point_deg
    return 118.0


def _saw_feeds(cuts: Sequence[Cut], saw: Saw, name: str) -> Iterator[Diagnostic]:
    """Cuts that do not run at the saw's own feed."""
    for cut in cuts:
        if abs(cut.feed_mm_min - saw.feed_mm_min) > 0.1:
            yield rules.FEED.at(
                Source(name, cut.line),
                found=f"{cut.feed_mm_min:g}",
                what="the saw",
                expected=f"{saw.feed_mm_min:g}",
            )


def _feed(bore: Bore, grade: str, drill: Drill, name: str) -> Iterator[Diagnostic]:
    """A feed beyond what the station can do, or one that is not the machine's own."""
    own = _drill_feed(bore.diameter, grade, drill)
    found, what = f"{bore.feed_mm_min:g}", f"a drill {bore.diameter:g}"
    if bore.feed_mm_min > drill.greatest_feed_mm_min + 0.1:
        expected = f"{drill.greatest_feed_mm_min:g}"
        yield rules.FEED_LIMIT.at(
            Source(name, bore.line), found=found, what=what, expected=expected
        )
    elif abs(bore.feed_mm_min - own) > 0.1 + 0.001 * own:
        yield rules.FEED.at(Source(name, bore.line), found=found, what=what, expected=f"{own:.4g}")


def _drill_feed(diameter: float, grade: str, drill: Drill) -> float:
    """The machine's feed in mm/min for a drill: turns times feed per turn.

    The speed at the edge gives the turns, n = 1000 v / (pi d), within the spindle's range.
    """
    rows = [
        c for c in drill.cutting
        if diameter <= c.up_to and fnmatchcase(grade.upper(), c.grade.upper())
    ]  # fmt: skip
    row = rows[0] if rows else drill.cutting[-1]
    turns = 1000 * row.speed_m_min / (pi * diameter)
    turns = max(drill.least_speed_rpm, min(drill.greatest_speed_rpm, turns))
    return min(turns * row.feed_per_turn, drill.greatest_feed_mm_min)


def _after_its_cut(
    matches: Sequence[Match], made: Made, last_cuts: Sequence[int | None], name: str
) -> Iterator[Diagnostic]:
    """Holes of a part that has been parted before."""
    parted: dict[int, int] = {}  #: line of a cut -> its place in the order of work
    place: dict[int, int] = {}
    for index, op in enumerate(made.order):
        (parted if type(op) is Cut else place)[op.line] = index
    for match in matches:
        line = last_cuts[match.wanted.part]
        if line is not None and place[match.bore.line] > parted[line]:
            yield rules.CUT_OFF.at(
                Source(name, match.bore.line), found=f"{match.bore.x:g}", cut=line
            )
