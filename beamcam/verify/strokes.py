"""Whether the tool, the depth and the feed of a stroke are right for the hole that it makes."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from math import pi, radians, tan

from msgspec import Struct

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import FLAT_DEG, Machine
from beamcam.model.part import Part, Profile
from beamcam.verify import rules
from beamcam.verify.depths import REACHES, Reach
from beamcam.verify.made import Bore, Trail
from beamcam.verify.matching import Match
from beamcam.verify.meaning import Meaning
from beamcam.verify.needs import PLAIN_KINDS, Stroke
from beamcam.verify.plain import plain_wants
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


def judge_strokes(matches: Sequence[Match], task: Task) -> Iterator[Diagnostic]:
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
            found += off_feed(bore, task.parts[need.part].grade, task)
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
    yield from off_reach(bore.tip_depth, bore.tip_depth, reach, _described(need, task.parts),
                          bore, task)  # fmt: skip


def _stroke_end(bore: Bore, thickness: float, profile: Profile, task: Task) -> float:
    """How deep the machine's own stroke goes, which may be one for all holes."""
    spindle = next(s for s in task.machine.spindles if s.face == bore.face)
    values = stroke_values(task.machine, profile, bore.face)
    tip = task.rack.tip(bore.kind, bore.diameter, bore.face)
    values |= {"depth": thickness + task.rack.drill.breakthrough, "tip": tip, "y": bore.y}
    station = next(s for s in task.choices[bore.spindle].stations if s.face == bore.face)
    return station.tip_depth(spindle.stroke.bottom(values), bore.y)


def off_reach(
    least: float, greatest: float, reach: Reach, described: dict[str, object],
    op: Bore | Trail, task: Task,
) -> Iterator[Diagnostic]:  # fmt: skip
    """A tip that turned back, between `least` and `greatest`, outside of its reach."""
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


def off_feed(op: Bore | Trail, grade: str, task: Task) -> Iterator[Diagnostic]:
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
    material = next(
        (t.tool_material for t in task.rack.kinds.get(kind, ()) if diameter in t.sizes), "hss"
    )
    row = next(
        (
            r
            for r in rows
            if diameter <= r.up_to
            and r.tool_material in ("*", material)
            and any(fnmatchcase(grade.upper(), p.strip()) for p in r.grade.upper().split("|"))
        ),
        rows[-1],
    )
    limit = drill.greatest_feed_mm_min
    if kind in ("punch", "scribe"):
        return min(1000 * row.speed_m_min, limit)
    turns = 1000 * row.speed_m_min / (pi * diameter)
    turns = max(drill.least_speed_rpm, min(drill.greatest_speed_rpm, turns))
    return min(turns * (pitch if kind == "tap" else row.feed_per_turn), limit)
