"""The holes that a program makes against those that the parts ask for, each exactly once.

A hole is right if it lies in its place, its tool is of a size that fits and the shop has, and it
reaches its wall. Of several at one place each is made by the tool that leaves it. A stroke of two
spindles at once may stand between its two holes, and what follows a drill where that one was.

Required depth of each kind of tool: from the part's dimensions to the position of the tip.

drill         through: its full diameter beyond the far side, at most as the machine strokes;
              blind: the full diameter at the depth; before a thread at least the thread's
tap           through: its tip beyond the far side; blind: its tip at the depth
countersink   the cone as wide as the sink where it is to be, the flat at its depth
punch         as deep as the part or the machine file says
mill, scribe  through: beyond the far side; else at the depth
"""

from collections.abc import Iterable, Iterator, Sequence
from math import floor, inf, radians, tan

from msgspec import Struct

from beamcam.checks import rules
from beamcam.checks.bars.stations import Bore, Choice, stroke_values, wall_thickness
from beamcam.checks.bars.targets import THREADS, RequiredRound, RoundKind
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.errors import Diagnostic, Source
from beamcam.machine.stations import FLAT_DEG
from beamcam.model.part import Part, Profile


class DepthRange(Struct, frozen=True, gc=False):
    """Permitted range of the tip's depth, from the surface of the face."""

    least: float
    greatest: float


def reach_of(
    kind: RoundKind, diameter: float, thickness: float, tools: ToolCatalogue
) -> DepthRange:
    """Permitted depth of the tip of a tool of a diameter that leaves what is required."""
    hole, depth = kind.hole, kind.hole.depth
    if kind.tool in ("drill", "tap"):
        tip = tools.tip(kind.tool, diameter, hole.face)
        point = tip if kind.tool == "drill" else 0.0  # a tap cuts its thread from its tip on
        if depth is None:
            return DepthRange(thickness + point, thickness + tools.drill.breakthrough + tip)
        least = most = depth + point
        if kind.tool == "drill" and hole.kind in THREADS:
            most = max(least, thickness or inf)
        return DepthRange(least, most)
    if kind.tool == "punch":
        depth = depth or tools.drill.punch_depth
    elif (cone := hole.angle or FLAT_DEG) < FLAT_DEG:
        slope = tan(radians(cone) / 2)
        alone = (hole.diameter - kind.pilot) / 2 / slope
        deep = depth or alone
        depth = hole.diameter / 2 / slope
        if deep > alone + tools.drill.sink_tolerance:
            depth = deep + kind.pilot / 2 / slope
    return DepthRange(depth or 0.0, depth or 0.0)


NOUNS = {"drill": "hole", "tap": "thread", "countersink": "countersink", "punch": "punch mark"}
NEAR = 60.0  #: mm; a hole this near to where it should be is taken for it, in the wrong place


class RequiredHole(Struct, frozen=True, gc=False):
    """A hole of a part on the bar."""

    part: int
    target: RequiredRound
    x: float  #: machine X


class HoleCheck:
    """The holes of one program. `choices` say where its spindles stand on the section."""

    def __init__(
        self, bores: Sequence[Bore], tools: ToolCatalogue, profile: Profile,
        choices: dict[int, Choice], name: str,
    ) -> None:  # fmt: skip
        self.bores, self.tools, self.profile, self.name = bores, tools, profile, name
        self.choices, resolution = choices, tools.machine.format.resolution
        self.merge = tools.drill.merge_tolerance
        #: A bore may be off by half a step, and so may the cut that its part starts at.
        self.slack, self.y_slack = resolution + 1e-6, 0.75 * resolution + 1e-6
        self.pockets: dict[tuple[str, str, int], list[int]] = {}
        self.paired: set[int] = set()  #: strokes of two spindles at once
        before = 0
        for i, bore in enumerate(bores):
            if bore.line == before:
                self.paired |= {i - 1, i}
            before = bore.line
            # Most x are whole millimetres, in the middle of their own.
            place = bore.face, bore.kind, floor(bore.x + 0.5)
            self.pockets.setdefault(place, []).append(i)
        self.made: dict[int, RequiredHole] = {}  #: by the bore's index

    # Which bore makes which hole

    def take(self, required_holes: Iterable[RequiredHole]) -> list[RequiredHole]:
        """Give each hole the bore that makes it rightly; those that are left come back."""
        left = []
        for required in required_holes:
            best = self.right(required)
            if best is None:
                left.append(required)
            else:
                self.made[best] = required
        return left

    def right(self, required: RequiredHole) -> int | None:
        """The bore that makes a hole rightly, of those not taken: the nearest in size."""
        kind, fitting = required.target.kind, []
        for i in self._near(required):
            bore = self.bores[i]
            diameter, depth = bore.diameter, bore.tip_depth
            if not kind.least <= diameter <= kind.most:
                continue
            if diameter not in self.tools.sizes(kind.tool, bore.face):
                continue
            if kind.tool != "drill" and self._wrong_tool(kind, bore):
                continue
            thickness = wall_thickness(self.profile, bore.face)
            reach = reach_of(kind, diameter, thickness, self.tools)
            if depth < reach.least - self.slack:
                continue
            most = reach.greatest + self.slack
            if depth <= most or depth <= self._reach(kind, bore).greatest + self.slack:
                fitting.append(i)
        if len(fitting) < 2:
            return fitting[0] if fitting else None
        return min(fitting, key=lambda i: self._unlike(required, self.bores[i]))

    def _near(self, required: RequiredHole) -> list[int]:
        """The bores at a hole's place that are not taken."""
        x, target = required.x, required.target
        y, face, kind = target.y, target.face, target.kind.tool
        x_slack, y_slack = x_reach, y_reach = self.slack, self.y_slack
        is_drilled = kind == "drill"
        if not is_drilled or self.paired:
            x_reach, y_reach = x_slack + self.merge, y_slack + self.merge
        near = []
        for place in range(floor(x + 0.5 - x_reach), floor(x + 0.5 + x_reach) + 1):
            for i in self.pockets.get((face, kind, place), ()):
                bore = self.bores[i]
                off_x, off_y = abs(bore.x - x), abs(bore.y - y)
                if i in self.made or off_x > x_reach or off_y > y_reach:
                    continue
                if is_drilled and i not in self.paired and (off_x > x_slack or off_y > y_slack):
                    continue
                near.append(i)
        return near

    def _unlike(self, required: RequiredHole, bore: Bore) -> tuple[float, float]:
        off = abs(required.x - bore.x) + abs(required.target.y - bore.y)
        return round(abs(required.target.kind.own - bore.diameter), 6), round(off, 6)

    def _reach(self, kind: RoundKind, bore: Bore) -> DepthRange:
        """Permitted depth of the tip in a hole; through holes as deep as the machine strokes."""
        thickness, tools = wall_thickness(self.profile, bore.face), self.tools
        reach = reach_of(kind, bore.diameter, thickness, tools)
        if kind.hole.depth is not None or kind.tool not in ("drill", "tap"):
            return reach
        # The machine's own stroke may be the same for all holes.
        stations = (s for choice in self.choices.values() for s in choice.stations)
        station = next(s for s in stations if s.face == bore.face)
        values = stroke_values(tools.machine, self.profile, bore.face)
        tip = tools.tip(bore.kind, bore.diameter, bore.face)
        values |= {"depth": thickness + tools.drill.breakthrough, "tip": tip, "y": bore.y}
        own = station.tip_depth(station.spindle.stroke.bottom(values), bore.y)
        return DepthRange(reach.least, max(reach.greatest, own))

    def _wrong_tool(self, kind: RoundKind, bore: Bore) -> str:
        """The required tap or countersink if the tool is wrong, else ""."""
        if kind.tool == "tap" and abs(bore.pitch - kind.pitch) > 1e-6:
            return f"pitch {kind.pitch:g}"
        if kind.tool == "countersink":
            cone = kind.hole.angle or FLAT_DEG
            cones = {
                t.point_deg for t in self.tools.of("countersink", bore.face)
                if bore.diameter in t.sizes
            }  # fmt: skip
            if cone not in cones:
                return f"a cone of {cone:g} degrees"
        return ""

    # What is wrong

    def complain(self, left: Sequence[RequiredHole], parts: Sequence[Part]) -> Iterator[Diagnostic]:
        """Faults of the holes that are not made correctly, and bores that belong to no hole."""
        yield from self._off_their_place(parts)
        far: list[RequiredHole] = []
        for required in left:
            if required.target.optional:
                continue
            near = self._near(required)
            if not near:
                far.append(required)
                continue
            best = min(near, key=lambda i: self._unlike(required, self.bores[i]))
            self.made[best] = required
            yield self._not_right(required, self.bores[best], parts)
        for required in far:
            x, target = required.x, required.target
            # The bores of its face and tool that may have been meant for it.
            meant = [
                (abs(b.x - x) + abs(b.y - target.y), i)
                for i, b in enumerate(self.bores)
                if i not in self.made and b.face == target.face and b.kind == target.kind.tool
                and abs(b.x - x) <= NEAR and abs(b.y - target.y) <= NEAR
            ]  # fmt: skip
            if meant:
                nearest = min(meant)[1]
                self.made[nearest] = required
                yield self._elsewhere(required, self.bores[nearest], parts)
            else:
                described = self._described(required, parts)
                source = target.kind.hole.source
                yield rules.HOLE_MISSING.at(source, machine_x=f"{x:g}", **described)
        for i, bore in enumerate(self.bores):
            if i not in self.made:
                yield rules.HOLE_EXTRA.at(
                    Source(self.name, bore.line),
                    what=f"{NOUNS.get(bore.kind, bore.kind)} {bore.diameter:g}",
                    face=bore.face, x=f"{bore.x:g}", y=f"{bore.y:g}",
                )  # fmt: skip

    def _off_their_place(self, parts: Sequence[Part]) -> Iterator[Diagnostic]:
        """Bores that may stand off their hole by the merging tolerance, and stand off for nothing.

        A stroke of two spindles lies between its two holes, what follows a drill where that was.
        """
        slack, y_slack = self.slack, self.y_slack
        drilled: set[tuple[str, float, float]] | None = None
        by_line: dict[int, list[RequiredHole]] = {}
        for i in self.paired:
            if i in self.made:
                by_line.setdefault(self.bores[i].line, []).append(self.made[i])
        for i, required in self.made.items():
            bore = self.bores[i]
            if abs(bore.x - required.x) <= slack and abs(bore.y - required.target.y) <= y_slack:
                continue
            if bore.kind != "drill":
                if drilled is None:
                    drilled = {(b.face, b.x, b.y) for b in self.bores if b.kind == "drill"}
                if (bore.face, bore.x, bore.y) in drilled:
                    continue
            both = by_line.get(bore.line, [required])
            xs, ys = [w.x for w in both], [w.target.y for w in both]
            if not (
                min(xs) - slack <= bore.x <= max(xs) + slack
                and min(ys) - y_slack <= bore.y <= max(ys) + y_slack
            ):
                yield self._elsewhere(required, bore, parts)

    def _described(self, required: RequiredHole, parts: Sequence[Part]) -> dict[str, object]:
        """Name of a hole in messages."""
        target = required.target
        return {
            "what": target.kind.what, "face": target.face, "mark": parts[required.part].mark,
            "x": f"{target.x:g}", "y": f"{target.y:g}",
        }  # fmt: skip

    def _not_right(self, required: RequiredHole, bore: Bore, parts: Sequence[Part]) -> Diagnostic:
        """The fault of the tool, or else of the depth, of a hole in its place."""
        kind, source = required.target.kind, Source(self.name, bore.line)
        described = self._described(required, parts)
        found, expected = f"a {kind.tool} {bore.diameter:g}", f"a {kind.tool} {kind.own:g}"
        if bore.diameter not in self.tools.sizes(kind.tool, bore.face):
            expected += ", the shop has none of that size"
        elif kind.least <= bore.diameter <= kind.most:
            expected = self._wrong_tool(kind, bore)
            if kind.tool == "tap":
                found = f"a tap of pitch {bore.pitch:g}"
        if expected:
            return rules.TOOL.at(source, found=found, expected=expected, **described)
        reach, depths = self._reach(kind, bore), (bore.tip_depth, bore.tip_depth)
        tip = self.tools.tip("drill", bore.diameter, bore.face) if bore.kind == "drill" else 0.0
        return wrong_depth(depths, reach, tip, self.slack, source, described)

    def _elsewhere(self, required: RequiredHole, bore: Bore, parts: Sequence[Part]) -> Diagnostic:
        return rules.HOLE_PLACE.at(
            Source(self.name, bore.line),
            found_x=f"{required.target.x + bore.x - required.x:.6g}",
            found_y=f"{bore.y:.6g}",
            **self._described(required, parts),
        )


def wrong_depth(
    tip_depths: tuple[float, float], reach: DepthRange, tip: float, slack: float, source: Source,
    described: dict[str, object],
) -> Diagnostic:  # fmt: skip
    """A tip that turned back, between two depths, outside of its reach."""
    found, expected = tip_depths[1], f"at most {reach.greatest - tip:.3f}"
    if tip_depths[0] < reach.least - slack:
        found, expected = tip_depths[0], f"at least {reach.least - tip:.3f}"
    if reach.least == reach.greatest:
        expected = f"{reach.least - tip:.3f}"
    return rules.DEPTH.at(source, found=f"{found - tip:.3f}", expected=expected, **described)
