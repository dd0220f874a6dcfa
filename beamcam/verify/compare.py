"""What a program makes against what its parts need: everything once, in its place, nothing else."""

from collections.abc import Collection, Iterator, Sequence
from fnmatch import fnmatchcase
from math import inf, isnan, pi, radians, tan

from msgspec import Struct

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import FLAT_DEG, Machine, Saw
from beamcam.model.part import Part, Profile
from beamcam.verify import rules
from beamcam.verify.depths import REACHES, Reach, path_reach
from beamcam.verify.ends import ends_of
from beamcam.verify.made import Bore, Cut, Made, Trail
from beamcam.verify.matching import Match, Matching, Wanted
from beamcam.verify.meaning import Meaning
from beamcam.verify.needs import (
    PLAIN_KINDS,
    Course,
    FeatureRef,
    Lack,
    Pocket,
    Stroke,
    needs_of,
)
from beamcam.verify.paths import line_error, pocket_error
from beamcam.verify.placing import NEAR, Placing
from beamcam.verify.plain import plain_wants, plainly_made
from beamcam.verify.rack import Rack, Wants
from beamcam.verify.stations import Choice, stroke_values


class Task(Struct, frozen=True):
    """What a comparison works with."""

    parts: Sequence[Part]
    machine: Machine
    rack: Rack
    meaning: Meaning
    choices: dict[int, Choice]
    name: str  #: of the program
    starts: Sequence[float]  #: of the parts on the bar

    def at(self, line: int) -> Source:
        return Source(self.name, line)


def compare(
    made: Made,
    parts: Sequence[Part],
    machine: Machine,
    rack: Rack,
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
    by_part = {id(part): ends_of(part, saw) for part in parts}
    ends = [by_part[id(part)] for part in parts]
    placing.place(parts, ends)
    said += placing.said
    if meaning.saw_feeds:
        said += _saw_feeds(made.cuts, saw, name)
    task = Task(parts, machine, rack, meaning, choices, name, placing.starts)
    from_x = [drill.x + start for start in placing.starts]
    resolution = machine.format.resolution
    drilled = None if skipped else plainly_made(made.bores, parts, from_x, rack, resolution)
    wanted: list[Wanted] = []
    paths: list[Pocket | Course] = []
    for _, need in needs_of(parts, ends, rack, skipped, drilled is None):
        if type(need) is Stroke:
            wanted.append(Wanted(need, from_x[need.part] + need.x))
        elif isinstance(need, Lack):
            said.append(_lack(need, parts))
        elif not isinstance(need, Stroke):
            paths.append(need)
    if drilled is None:
        matching = Matching(wanted, parts, resolution, rack, name)
        matches = sorted(matching.run(made.bores, said), key=lambda match: match.bore.line)
        said += _strokes(matches, task)
        drilled = [(match.need.part, match.bore) for match in matches]
    if made.trails or paths:
        said += _paths(made.trails, paths, task)
    if machine.layout is not None and machine.layout.order == "drill-saw":
        said += _after_its_cut(drilled, made, placing.last_cut, name)
    return tuple(said)


def _strokes(matches: Sequence[Match], task: Task) -> Iterator[Diagnostic]:
    """What is wrong with tool, depth and feed of the strokes."""
    rack = task.rack
    fine = [rack.fine(part.profile, part.grade) for part in task.parts]
    for match in matches:
        need, bore, _ = match
        # Most holes are like one before.
        wants, tooled = _wants(match), bore[4:]
        if tooled in fine[need.part].get(wants, ()):
            continue
        found = [*_tool(match, task)]
        if not errors_in(found):  # another tool has another depth and feed, of course
            found += _depth(match, task)
            found += _feed(bore, task.parts[need.part].grade, task)
        if found:
            yield from found
        else:
            rack.remember(fine[need.part], wants, tooled)


def _wants(match: Match) -> Wants:
    """What a stroke has to make, but for its place."""
    need, _, size = match
    hole = need.hole
    if need.kind == "drill" and size == hole.diameter and hole.kind in PLAIN_KINDS:
        return plain_wants(hole)
    return (
        need.kind, hole.face, hole.kind, hole.diameter, hole.depth, hole.angle, need.diameter,
        need.pilot, size,
    )  # fmt: skip


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


def _lack(need: Lack, parts: Sequence[Part]) -> Diagnostic:
    mark = parts[need.part].mark
    if need.place is None:
        return rules.NOT_MADE.at(need.feature.source, found=need.what, mark=mark)
    x, y = need.place
    face = getattr(need.feature, "face", "")
    return rules.OUTLINE.at(need.feature.source, face=face, mark=mark, x=f"{x:g}", y=f"{y:g}")


def _described(need: Stroke, parts: Sequence[Part]) -> dict[str, object]:
    """How messages name a hole."""
    hole = need.hole
    return {
        "what": need.what, "face": hole.face, "mark": parts[need.part].mark,
        "x": f"{hole.x:g}", "y": f"{hole.y:g}",
    }  # fmt: skip


def _tool(match: Match, task: Task) -> Iterator[Diagnostic]:
    """What is wrong with the tool that makes a hole."""
    need, bore, size = match
    rack, face = task.rack, need.hole.face
    own, fit = _own_tool(match, rack)
    found = f"a {need.kind} {bore.diameter:g}"
    described = _described(need, task.parts)
    if fit is not None and not fit[0] <= bore.diameter <= fit[1]:
        expected = f"a {need.kind} {own:g}"
        yield rules.TOOL.at(task.at(bore.line), found=found, expected=expected, **described)
    elif bore.diameter not in rack.sizes(need.kind, face):
        expected = f"a {need.kind} {own:g}, the shop has none of that size"
        yield rules.TOOL.at(task.at(bore.line), found=found, expected=expected, **described)
    elif need.kind == "drill" and not _as_good(bore.diameter, own, size, rack):
        yield rules.TOOL_NEARER.at(
            task.at(bore.line), found=f"{bore.diameter:g}", expected=f"{own:g}", **described
        )
    if need.kind == "tap":
        tap = rack.tap(need.hole)
        if tap is not None and abs(bore.pitch - tap[1]) > 1e-6:
            found, expected = f"a tap of pitch {bore.pitch:g}", f"pitch {tap[1]:g}"
            yield rules.TOOL.at(task.at(bore.line), found=found, expected=expected, **described)
    if need.kind == "countersink" and rack.point_deg("countersink", bore.diameter, face) != (
        need.hole.angle or FLAT_DEG
    ):
        cones = {t.point_deg for t in rack.of("countersink", face) if bore.diameter in t.sizes}
        if (need.hole.angle or FLAT_DEG) not in cones:
            yield rules.TOOL.at(
                task.at(bore.line), found=found,
                expected=f"a cone of {need.hole.angle or FLAT_DEG:g} degrees", **described,
            )  # fmt: skip


def _own_tool(match: Match, rack: Rack) -> tuple[float, tuple[float, float] | None]:
    """The diameter that a stroke wants, and from which to which any would do; None is any."""
    need, _, size = match
    hole = need.hole
    if need.kind == "drill":
        wanted = size if need.diameter == rack.drills(hole.diameter, hole.face) else need.diameter
        return rack.drills(wanted, hole.face) or need.diameter, rack.fit(wanted)
    if need.kind == "tap":
        return need.diameter, (need.diameter, need.diameter)
    if need.kind == "countersink":
        cone = hole.angle or FLAT_DEG
        if cone < FLAT_DEG and REACHES["countersink"](need, hole.diameter, 0.0, rack).least <= (
            hole.diameter / 2 / _slope(cone) + 1e-9
        ):
            return hole.diameter, (hole.diameter - 1e-6, float("inf"))
        return hole.diameter, rack.fit(hole.diameter)
    return next((d for t in rack.of(need.kind, hole.face) for d in t.sizes), 0.0), None


def _slope(cone_deg: float) -> float:
    return tan(radians(cone_deg) / 2)


def _as_good(found: float, own: float, size: float, rack: Rack) -> bool:
    """Whether a drill is as good as the nearest one, but for what counts as one tool."""
    return abs(found - size) - abs(own - size) <= rack.drill.twin + 1e-6


def _depth(match: Match, task: Task) -> Iterator[Diagnostic]:
    """What is wrong with the depth of a hole."""
    need, bore, _ = match
    profile = task.parts[need.part].profile
    face = need.hole.face
    thickness = profile.thickness(face)
    reach = REACHES[need.kind](need, bore.diameter, thickness, task.rack)
    if need.hole.depth is None and need.kind in ("drill", "tap"):
        reach = Reach(reach.least, max(reach.greatest, _stroke_end(bore, thickness, profile, task)))
    yield from _off_reach(bore.tip_depth, bore.tip_depth, reach, _described(need, task.parts),
                          bore, task)  # fmt: skip


def _stroke_end(bore: Bore, thickness: float, profile: Profile, task: Task) -> float:
    """How deep the machine's own stroke goes, which may be one for all holes."""
    spindle = next(s for s in task.machine.spindles if s.face == bore.face)
    values = stroke_values(task.machine, profile, bore.face)
    tip = task.rack.tip(bore.kind, bore.diameter, bore.face)
    values |= {"depth": thickness + task.rack.drill.breakthrough, "tip": tip, "y": bore.y}
    station = next(s for s in task.choices[bore.spindle].stations if s.face == bore.face)
    return station.tip_depth(spindle.stroke.bottom(values))


def _off_reach(
    least: float, greatest: float, reach: Reach, described: dict[str, object],
    op: Bore | Trail, task: Task,
) -> Iterator[Diagnostic]:  # fmt: skip
    slack = task.machine.format.resolution + 1e-6
    tip = 0.0 if op.kind != "drill" else task.rack.tip("drill", op.diameter, op.face)
    found, expected = 0.0, ""
    if least < reach.least - slack:
        found, expected = least, f"at least {reach.least - tip:.3f}"
    elif greatest > reach.greatest + slack:
        found, expected = greatest, f"at most {reach.greatest - tip:.3f}"
    if expected:
        if reach.least == reach.greatest:
            expected = f"{reach.least - tip:.3f}"
        yield rules.DEPTH.at(
            task.at(op.line), found=f"{found - tip:.3f}", expected=expected, **described
        )


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


def _feed(op: Bore | Trail, grade: str, task: Task) -> Iterator[Diagnostic]:
    """A feed beyond what the station can do, or one that is not the machine's own."""
    if not task.meaning.feeds:
        return
    pitch = op.pitch if isinstance(op, Bore) else 0.0
    own = _own_feed(op.kind, op.diameter, pitch, grade, task)
    found, what = f"{op.feed_mm_min:g}", f"a {op.kind} {op.diameter:g}"
    limit = task.rack.drill.greatest_feed_mm_min
    if op.feed_mm_min > limit + 0.1:
        yield rules.FEED_LIMIT.at(task.at(op.line), found=found, what=what, expected=f"{limit:g}")
    elif own is not None and abs(op.feed_mm_min - own) > 0.1 + 0.001 * own:
        yield rules.FEED.at(task.at(op.line), found=found, what=what, expected=f"{own:.4g}")


def _own_feed(kind: str, diameter: float, pitch: float, grade: str, task: Task) -> float | None:
    """The machine's feed in mm/min for a tool: turns times feed per turn, of a tap its pitch.

    The speed at the edge gives the turns, n = 1000 v / (pi d), within the spindle's range; what
    does not turn is fed at that speed. None if the machine has no row for the kind.
    """
    drill = task.rack.drill
    rows = [row for row in drill.cutting if row.kind == kind]
    if not rows:
        return None
    row = next(
        (r for r in rows if diameter <= r.up_to and fnmatchcase(grade.upper(), r.grade.upper())),
        rows[-1],
    )
    limit = drill.greatest_feed_mm_min
    if kind in ("punch", "scribe"):
        return min(1000 * row.speed_m_min, limit)
    turns = 1000 * row.speed_m_min / (pi * diameter)
    turns = max(drill.least_speed_rpm, min(drill.greatest_speed_rpm, turns))
    return min(turns * (pitch if kind == "tap" else row.feed_per_turn), limit)


def _paths(
    trails: Sequence[Trail], wanted: Sequence[Pocket | Course], task: Task
) -> Iterator[Diagnostic]:
    """What is wrong with the paths: each pocket and line once, by the path that fits it best."""
    drill_x, resolution = task.rack.drill.x, task.machine.format.resolution
    allowed = task.rack.drill.path_tolerance + 2 * resolution
    left = list(trails)
    for need in wanted:
        kind = "mill" if isinstance(need, Pocket) else "scribe"
        from_x = drill_x + task.starts[need.part]
        # The nearest path is meant; measuring it point by point is the dear part.
        near = [
            (_apart(trail, need, from_x), trail.line, trail)
            for trail in left
            if trail.kind == kind and trail.face == need.face
        ]
        mark = task.parts[need.part].mark
        what = need.what if isinstance(need, Pocket) else "line to mark"
        apart, _, trail = min(near, key=lambda n: n[:2], default=(inf, 0, None))
        if trail is None or apart > NEAR:
            yield rules.NOT_MADE.at(need.source.source, found=f"the {what}", mark=mark)
            continue
        off = _error(need, [(x - from_x, y) for x, y in trail.points], trail)
        left.remove(trail)
        if off > allowed:
            yield rules.PATH.at(
                task.at(trail.line), what=f"the {what}", mark=mark, found=f"{off:.3f}",
                expected=f"{allowed:g}",
            )  # fmt: skip
        yield from _trail(trail, need, what, task)
    for trail in left:
        x, y = trail.points[0]
        yield rules.PATH_EXTRA.at(
            task.at(trail.line), kind=trail.kind, face=trail.face, x=f"{x:g}", y=f"{y:g}"
        )


def _apart(trail: Trail, need: Pocket | Course, from_x: float) -> float:
    """How far the middles of a path and of what it may be meant for are apart."""
    x, y = _middle(trail.points)
    if isinstance(need, Pocket):
        own_x, own_y = need.x, need.y
    else:
        boxes = [curve.bbox for curve in need.curves]
        corners = [(b[0], b[1]) for b in boxes] + [(b[2], b[3]) for b in boxes]
        own_x, own_y = _middle(corners)
    return abs(x - from_x - own_x) + abs(y - own_y)


def _middle(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2


def _error(need: Pocket | Course, points: Sequence[tuple[float, float]], trail: Trail) -> float:
    if isinstance(need, Pocket):
        return pocket_error(need, points, trail.diameter)
    return line_error(need.curves, points)


def _trail(trail: Trail, need: Pocket | Course, what: str, task: Task) -> Iterator[Diagnostic]:
    """What is wrong with the tool, the depth and the feed of a path."""
    part = task.parts[need.part]
    x, y = (need.x, need.y) if isinstance(need, Pocket) else need.curves[0].start
    described: dict[str, object] = {
        "what": what, "face": need.face, "mark": part.mark, "x": f"{x:g}", "y": f"{y:g}",
    }  # fmt: skip
    sizes = sorted(task.rack.sizes(trail.kind, need.face))
    if trail.diameter not in sizes:
        shown = ", ".join(f"{d:g}" for d in sizes)
        yield rules.TOOL.at(
            task.at(trail.line), found=f"a {trail.kind} {trail.diameter:g}",
            expected=f"one of {shown}", **described,
        )  # fmt: skip
        return
    if isinstance(need, Pocket):
        reach = path_reach(need.depth, part.profile.thickness(need.face), task.rack)
    else:
        reach = Reach(task.rack.drill.mark_depth, task.rack.drill.mark_depth)
    yield from _off_reach(trail.least_depth, trail.greatest_depth, reach, described, trail, task)
    yield from _feed(trail, part.grade, task)


def _after_its_cut(
    drilled: Sequence[tuple[int, Bore]], made: Made, last_cuts: Sequence[int | None], name: str
) -> Iterator[Diagnostic]:
    """Holes of a part, by its index, that has been parted before."""
    parted: dict[int, int] = {}  #: line of a cut -> its place in the order of work
    place: dict[int, int] = {}
    for index, op in enumerate(made.order):
        (parted if type(op) is Cut else place)[op.line] = index
    for part, bore in sorted(drilled, key=lambda one: one[1].line):
        line = last_cuts[part]
        if line is not None and place[bore.line] > parted[line]:
            yield rules.CUT_OFF.at(Source(name, bore.line), found=f"{bore.x:g}", cut=line)
