"""The steps of a hole: drill, drill and tap, sink, punch, or mill round.

    through, blind    one drill of a fitting diameter; larger than any drill: a mill led round
    thread            the drill before the tap, deeper by the tap's run-out, and the tap
    countersink       its own row in DSTV, beside the row of the hole that it sinks
    mark              a centre punch

How deep a cone goes follows from its outer diameter D, its angle a and the hole d below it:

    |<----- D ----->|
    \\               /   ^             a cone alone:  depth = (D - d) / 2 / tan(a / 2)
      \\    a      /     | depth       deeper: it stands below the surface, and only a tool
        |< d  >|        v             of diameter D leaves that cylinder above it
          tip            point of the tool: depth + d / 2 / tan(a / 2)
"""

from collections.abc import Mapping
from math import radians, tan
from typing import cast

from msgspec import Struct

from beamcam.errors import Rule, Severity
from beamcam.machine.tools import FLAT_DEG
from beamcam.model.part import Face, HoleKind
from beamcam.planning.operations.tools import ROUNDING, Tooling, ToolLibrary, Tools, fit_of
from beamcam.planning.rules import MARK, NO_TOOL, no_unit

NO_PILOT = Rule(
    "plan-countersink",
    Severity.ERROR,
    "found a countersink of diameter {found} on face {face} at x {x}, y {y}; "
    "expected a hole to sink at that place",
    "DSTV gives a countersunk hole in two rows, the sink and the hole; one of them is missing.",
)
SINK_DEPTH = Rule(
    "plan-sink-depth",
    Severity.ERROR,
    "found a countersink of diameter {found} and depth {depth} on face {face}; "
    "expected a depth of at least {expected} for that cone and hole",
    "Diameter, depth, cone and hole contradict each other, and only three of them can be right.",
)
THREAD_DEPTH = Rule(
    "plan-thread-depth",
    Severity.ERROR,
    "found a thread of depth {found} on face {face}; "
    "expected at most {expected}, the tapping drill would come through",
    "The drill before a blind tap goes deeper than the thread by the tap's run-out.",
)
RULES = (NO_PILOT, SINK_DEPTH, THREAD_DEPTH)


class HoleWork(Struct, frozen=True):
    """A hole, or one and the same on both flanges (two faces), wherever it is."""

    kind: HoleKind
    diameters: tuple[float, ...]
    depth: float | None
    angle: float | None
    faces: tuple[Face, ...]
    thickness: float
    spindle: int
    why: tuple[str, ...]  #: it is made so, as codes
    pilot: float | None  #: diameter of the hole that a countersink sinks; None if there is none


class Refusal(Struct, frozen=True):
    """Why a hole cannot be made: a rule and the values of its message, except the place."""

    rule: Rule
    values: Mapping[str, object]


def toolings_of(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    """The tools that make a hole, in order; or why there are none."""
    known = library.toolings.get(hole)
    if known is None:
        known = library.toolings.keep(hole, _toolings(library, hole))
    return cast("tuple[Tooling, ...] | Refusal", known)


def _toolings(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    match hole.kind:
        case "through" | "blind":
            return _plain(library, hole)
        case "thread" | "left-thread":
            return _thread(library, hole)
        case "countersink":
            return _sink(library, hole)
        case "mark":
            punches = library.of_kind("punch", hole.faces)
            if not punches:
                why = no_unit("punch")
                return Refusal(MARK, {"found": "a centre punch", "face": hole.faces[0], "why": why})
            return (
                _step(hole, punches[:1], hole.depth or library.drill.punch_depth, "punch-mark"),
            )


def _step(hole: HoleWork, tools: Tools, depth: float | None, reason: str) -> Tooling:
    return Tooling(hole.spindle, tools, hole.faces, depth, (reason, *hole.why))


def _plain(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    faces, spindle, depth = hole.faces, hole.spindle, hole.depth
    drills = library.drills(hole.diameters, faces)
    if drills:
        return (Tooling(spindle, drills, faces, depth, hole.why, diameter=hole.diameters[0]),)
    diameter = max(hole.diameters)
    if len(faces) == 1 and diameter > library.largest_drill(faces):
        mills = library.ring_mill(diameter, faces)
        if mills:
            reasons = ("mill-circle", *hole.why)
            return (Tooling(spindle, mills, faces, depth, reasons, ring=diameter),)
    return _no_tool(library, hole)


def _thread(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    depth, thickness = hole.depth, hole.thickness
    taps = library.taps(max(hole.diameters), hole.kind == "left-thread", hole.faces)
    drills = library.drills((library.pre_drill(taps[0]),), hole.faces) if taps else ()
    if not drills:
        return _no_tool(library, hole)
    drilled = None
    if depth is not None:
        # The point has to stay inside too, or a blind thread would have a hole at its end.
        drilled = depth + library.drill.runout_pitches * taps[0].pitch
        deepest = drilled + drills[0].tip
        if thickness and deepest > thickness + ROUNDING:
            expected = f"{max(0.0, thickness - (deepest - depth)):.1f}"
            values = {"found": f"{depth:g}", "face": hole.faces[0], "expected": expected}
            return Refusal(THREAD_DEPTH, values)
    return (
        _step(hole, drills, drilled, "drill-before-tap"),
        _step(hole, taps, depth, "tap-thread"),
    )


def _sink(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    faces, depth, pilot, diameter = hole.faces, hole.depth, hole.pilot, max(hole.diameters)
    if pilot is None:
        return Refusal(NO_PILOT, {"found": f"{diameter:g}", "face": faces[0]})
    cone = hole.angle or FLAT_DEG
    if cone >= FLAT_DEG:
        tools = library.sinks(diameter, FLAT_DEG, True, faces) if depth else ()
        return (_step(hole, tools, depth, "sink-flat"),) if tools else _no_tool(library, hole)
    slope = tan(radians(cone) / 2)
    cone_depth = (diameter - pilot) / 2 / slope
    deep = depth or cone_depth
    if deep < cone_depth - library.drill.sink_tolerance:
        values = {
            "found": f"{diameter:g}", "depth": f"{deep:g}", "face": faces[0],
            "expected": f"{cone_depth:.2f}",
        }  # fmt: skip
        return Refusal(SINK_DEPTH, values)
    below = deep > cone_depth + library.drill.sink_tolerance
    tools = library.sinks(diameter, cone, below, faces)
    point = deep + pilot / 2 / slope if below else diameter / 2 / slope
    reason = "sink-deep" if below else "sink-cone"
    return (_step(hole, tools, point, reason),) if tools else _no_tool(library, hole)


def _no_tool(library: ToolLibrary, hole: HoleWork) -> Refusal:
    values = {
        "kind": hole.kind, "found": f"{max(hole.diameters):g}", "face": hole.faces[0],
        "expected": _nearest_tools(library, hole),
    }  # fmt: skip
    return Refusal(NO_TOOL, values)


def _nearest_tools(library: ToolLibrary, hole: HoleWork) -> str:
    """The tools that the machine has instead, for a message."""
    kind, faces, diameter = hole.kind, hole.faces, max(hole.diameters)
    if kind in ("thread", "left-thread"):
        taps = [f"M{t.diameter:g}" for t in library.of_kind("tap", faces) if t.hand == "right"]
        return f"one of {', '.join(taps)}" if taps else "none, the machine has no tap"
    if kind == "countersink":
        sinks = sorted({t.diameter for t in library.of_kind("countersink", faces)})
        shown = ", ".join(f"{d:g}" for d in sinks)
        return f"one that the countersinks {shown} make" if sinks else "none, it has no countersink"
    near = sorted((abs(t.diameter - diameter), t.diameter) for t in library.of_kind("drill", faces))
    if not near:
        return "none, the machine has no drill"
    shown = " or ".join(f"{d:g}" for _, d in near[:2])
    fit = fit_of(diameter, library.drill)
    if fit is None:
        return f"a hole near a drill of {shown}"
    limits = f"{diameter - fit.minus:g} to {diameter + fit.plus:g}"
    return f"a drill of {limits} (drill.fits); the nearest are {shown}"
