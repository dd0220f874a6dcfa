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

from collections.abc import Callable, Iterable, Iterator, Sequence
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


def _drill(kind: RoundKind, diameter: float, thickness: float, tools: ToolCatalogue) -> DepthRange:
    hole = kind.hole
    tip = tools.tip("drill", diameter, hole.face)
    if hole.depth is None:
        return DepthRange(thickness + tip, thickness + tools.drill.breakthrough + tip)
    if hole.kind in THREADS:
        return DepthRange(hole.depth + tip, max(hole.depth + tip, thickness or inf))
    return DepthRange(hole.depth + tip, hole.depth + tip)


def _tap(kind: RoundKind, diameter: float, thickness: float, tools: ToolCatalogue) -> DepthRange:
    if kind.hole.depth is None:
        tip = tools.tip("tap", diameter, kind.hole.face)
        return DepthRange(thickness, thickness + tools.drill.breakthrough + tip)
    return DepthRange(kind.hole.depth, kind.hole.depth)


def _sink(kind: RoundKind, diameter: float, thickness: float, tools: ToolCatalogue) -> DepthRange:
    hole = kind.hole
    cone = hole.angle or FLAT_DEG
    if cone >= FLAT_DEG:
        depth = hole.depth or 0.0
        return DepthRange(depth, depth)
    slope = tan(radians(cone) / 2)
    alone = (hole.diameter - kind.pilot) / 2 / slope
    deep = hole.depth or alone
    if deep > alone + tools.drill.sink_tolerance:
        point = deep + kind.pilot / 2 / slope
    else:
        point = hole.diameter / 2 / slope
    return DepthRange(point, point)


def _punch(kind: RoundKind, diameter: float, thickness: float, tools: ToolCatalogue) -> DepthRange:
    depth = kind.hole.depth or tools.drill.punch_depth
    return DepthRange(depth, depth)


#: By the kind of tool.
REACHES: dict[str, Callable[[RoundKind, float, float, ToolCatalogue], DepthRange]] = {
    "drill": _drill, "tap": _tap, "countersink": _sink, "punch": _punch,
}  # fmt: skip


def path_reach(depth: float | None, thickness: float, tools: ToolCatalogue) -> DepthRange:
    """Of a mill: through, or at a depth."""
    if depth is None:
        return DepthRange(thickness, thickness + tools.drill.breakthrough)
    return DepthRange(depth, depth)


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
        self.tools, self.profile, self.name = tools, profile, name
        resolution = tools.machine.format.resolution
        self.merge = tools.drill.merge_tolerance
        #: A bore may be off by half a step, and so may the cut that its part starts at.
        self.x_slack, self.y_slack = resolution + 1e-6, 0.75 * resolution + 1e-6
        self.depth_slack = resolution + 1e-6
        self.stations = {s.face: s for choice in choices.values() for s in choice.stations}
        self.pockets: dict[tuple[str, str, int], list[int]] = {}
        self.bores = bores
        self.paired = _paired(bores)
        for i, bore in enumerate(bores):
            self.pockets.setdefault((bore.face, bore.kind, floor(bore.x)), []).append(i)
        self.made: dict[int, RequiredHole] = {}  #: by the bore's index

    # Which bore makes which hole

    def take(self, required_holes: Iterable[RequiredHole]) -> list[RequiredHole]:
        """Give each hole the bore that makes it rightly; those that are left come back."""
        left = []
        for required in required_holes:
            best = self._right(required)
            if best is None:
                left.append(required)
            else:
                self.made[best] = required
        return left

    def is_made(self, required: RequiredHole) -> bool:
        """Whether something makes a hole rightly."""
        return self._right(required) is not None

    def _right(self, required: RequiredHole) -> int | None:
        """The bore that makes a hole rightly, of those not taken: the nearest in size."""
        near = [i for i in self._near(required) if self._is_right(required, self.bores[i])]
        if len(near) < 2:
            return near[0] if near else None
        return min(near, key=lambda i: self._unlike(required, self.bores[i]))

    def _near(self, required: RequiredHole) -> Iterator[int]:
        """The bores at a hole's place that are not taken."""
        x, target = required.x, required.target
        kind = target.kind.tool
        x_reach, y_reach = self.x_slack, self.y_slack
        loose = kind != "drill" or self.paired
        if loose:
            x_reach, y_reach = x_reach + self.merge, y_reach + self.merge
        low, high = floor(x - x_reach), floor(x + x_reach)
        for key in (low,) if low == high else range(low, high + 1):
            for i in self.pockets.get((target.face, kind, key), ()):
                bore = self.bores[i]
                off_x, off_y = abs(bore.x - x), abs(bore.y - target.y)
                if i in self.made or off_x > x_reach or off_y > y_reach:
                    continue
                if (
                    not loose
                    or kind != "drill"
                    or i in self.paired
                    or (off_x <= self.x_slack and off_y <= self.y_slack)
                ):
                    yield i

    def _is_right(self, required: RequiredHole, bore: Bore) -> bool:
        kind, diameter = required.target.kind, bore.diameter
        if not kind.least <= diameter <= kind.most:
            return False
        if diameter not in self.tools.sizes(kind.tool, bore.face):
            return False
        if kind.tool != "drill" and self._wrong_tool(kind, bore):
            return False
        reach = self._reach(kind, bore)
        if bore.tip_depth < reach.least - self.depth_slack:
            return False
        return (
            bore.tip_depth <= reach.greatest + self.depth_slack
            or bore.tip_depth <= self.reach(kind, bore).greatest + self.depth_slack
        )

    def _unlike(self, required: RequiredHole, bore: Bore) -> tuple[float, float]:
        off = abs(required.x - bore.x) + abs(required.target.y - bore.y)
        return round(abs(required.target.kind.own - bore.diameter), 6), round(off, 6)

    def reach(self, kind: RoundKind, bore: Bore) -> DepthRange:
        """Permitted depth of the tip in a hole; through holes as deep as the machine strokes."""
        reach = self._reach(kind, bore)
        if kind.hole.depth is None and kind.tool in ("drill", "tap"):
            thickness = wall_thickness(self.profile, bore.face)
            return DepthRange(reach.least, max(reach.greatest, self._stroke_end(bore, thickness)))
        return reach

    def _reach(self, kind: RoundKind, bore: Bore) -> DepthRange:
        return REACHES[kind.tool](
            kind, bore.diameter, wall_thickness(self.profile, bore.face), self.tools
        )

    def _stroke_end(self, bore: Bore, thickness: float) -> float:
        """Depth of the machine's own stroke, which may be fixed for all holes."""
        machine = self.tools.machine
        spindle = next(s for s in machine.spindles if s.face == bore.face)
        values = stroke_values(machine, self.profile, bore.face)
        tip = self.tools.tip(bore.kind, bore.diameter, bore.face)
        values |= {"depth": thickness + self.tools.drill.breakthrough, "tip": tip, "y": bore.y}
        return self.stations[bore.face].tip_depth(spindle.stroke.bottom(values), bore.y)

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
        yield from self._astray(parts)
        astray: list[RequiredHole] = []
        for required in left:
            if required.target.optional:
                continue
            near = [*self._near(required)]
            if not near:
                astray.append(required)
                continue
            best = min(near, key=lambda i: self._unlike(required, self.bores[i]))
            self.made[best] = required
            yield self._not_right(required, self.bores[best], parts)
        for required in astray:
            nearest = self._nearest(required)
            if nearest is None:
                yield self._missing(required, parts)
            else:
                self.made[nearest] = required
                yield self._elsewhere(required, self.bores[nearest], parts)
        for i, bore in enumerate(self.bores):
            if i not in self.made:
                yield rules.HOLE_EXTRA.at(
                    Source(self.name, bore.line),
                    what=f"{NOUNS.get(bore.kind, bore.kind)} {bore.diameter:g}",
                    face=bore.face, x=f"{bore.x:g}", y=f"{bore.y:g}",
                )  # fmt: skip

    def _astray(self, parts: Sequence[Part]) -> Iterator[Diagnostic]:
        """Bores that may stand off their hole by the merging tolerance, and stand off for nothing.

        A stroke of two spindles lies between its two holes, what follows a drill where that was.
        """
        drilled: set[tuple[str, float, float]] | None = None
        by_line: dict[int, list[RequiredHole]] = {}
        for i in self.paired:
            if i in self.made:
                by_line.setdefault(self.bores[i].line, []).append(self.made[i])
        for i, required in list(self.made.items()):
            bore = self.bores[i]
            if (
                abs(bore.x - required.x) <= self.x_slack
                and abs(bore.y - required.target.y) <= self.y_slack
            ):
                continue
            if bore.kind != "drill":
                if drilled is None:
                    drilled = {(b.face, b.x, b.y) for b in self.bores if b.kind == "drill"}
                if (bore.face, bore.x, bore.y) in drilled:
                    continue
            both = by_line.get(bore.line, [required])
            xs, ys = [w.x for w in both], [w.target.y for w in both]
            if not (
                min(xs) - self.x_slack <= bore.x <= max(xs) + self.x_slack
                and min(ys) - self.y_slack <= bore.y <= max(ys) + self.y_slack
            ):
                yield self._elsewhere(required, bore, parts)

    def _nearest(self, required: RequiredHole) -> int | None:
        """The bore of a hole's face and tool that may have been meant for it."""
        target = required.target
        near = [
            (abs(b.x - required.x) + abs(b.y - target.y), i)
            for i, b in enumerate(self.bores)
            if i not in self.made and b.face == target.face and b.kind == target.kind.tool
            and abs(b.x - required.x) <= NEAR and abs(b.y - target.y) <= NEAR
        ]  # fmt: skip
        return min(near)[1] if near else None

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
        reach = self.reach(kind, bore)
        tip = self.tools.tip("drill", bore.diameter, bore.face) if bore.kind == "drill" else 0.0
        return wrong_depth(
            (bore.tip_depth, bore.tip_depth), reach, tip, self.depth_slack, source, described
        )

    def _missing(self, required: RequiredHole, parts: Sequence[Part]) -> Diagnostic:
        return rules.HOLE_MISSING.at(
            required.target.kind.hole.source,
            machine_x=f"{required.x:g}",
            **self._described(required, parts),
        )

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


def _paired(bores: Sequence[Bore]) -> frozenset[int]:
    """The indices of bores that are strokes of two spindles at once."""
    paired: list[int] = []
    before = None
    for i, bore in enumerate(bores):
        if before is not None and bore.line == before.line:
            paired += (i - 1, i)
        before = bore
    return frozenset(paired)
