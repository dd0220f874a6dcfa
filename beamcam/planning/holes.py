"""What has to be done for a hole: drill, drill and tap, sink, punch, or mill round.

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

from beamcam.errors import Rule
from beamcam.machine.machine import FLAT_DEG
from beamcam.model.part import Face, HoleKind
from beamcam.planning import rules
from beamcam.planning.tools import ROUNDING, Rack, Tools


class Step(Struct, frozen=True):
    """One operation on a hole."""

    tools: Tools  #: any of which may do it
    depth: float | None  #: None is through
    reason: str  #: why this kind of tool; "" where it is the drill of a plain hole
    ring: float = 0.0  #: diameter of the circle that a mill leaves; 0 for a stroke


class Refusal(Struct, frozen=True):
    """Why there is no way to make a hole: a rule and what its message needs but the place."""

    rule: Rule
    values: Mapping[str, object]


Recipe = tuple[Step, ...]


def recipe(
    rack: Rack,
    kind: HoleKind,
    diameters: tuple[float, ...],
    depth: float | None,
    angle: float | None,
    faces: tuple[Face, ...],
    thickness: float,
    pilot: float | None = None,
) -> Recipe | Refusal:
    """The steps for a hole, or for one and the same on both flanges (two faces).

    `pilot` is the diameter of the hole that a countersink sinks, None if there is none.
    """
    key = kind, diameters, depth, angle, faces, thickness, pilot
    known = rack.recipes.get(key)
    if known is None:
        known = rack.recipes.keep(key, _recipe(rack, *key))
    return cast("Recipe | Refusal", known)


def _recipe(
    rack: Rack,
    kind: HoleKind,
    diameters: tuple[float, ...],
    depth: float | None,
    angle: float | None,
    faces: tuple[Face, ...],
    thickness: float,
    pilot: float | None,
) -> Recipe | Refusal:
    match kind:
        case "through" | "blind":
            return _plain(rack, kind, diameters, depth, faces)
        case "thread" | "left-thread":
            return _thread(rack, kind, diameters, depth, faces, thickness)
        case "countersink":
            return _sink(rack, diameters, depth, angle, faces, pilot)
        case "mark":
            punches = rack.of_kind("punch", faces)
            if not punches:
                return Refusal(
                    rules.MARK,
                    {"found": "a centre punch", "face": faces[0], "tool": "punch"},
                )
            return (Step(punches[:1], depth or rack.drill.punch_depth, "punch-mark"),)


def _plain(
    rack: Rack,
    kind: HoleKind,
    diameters: tuple[float, ...],
    depth: float | None,
    faces: tuple[Face, ...],
) -> Recipe | Refusal:
    drills = rack.drills(diameters, faces)
    if drills:
        return (Step(drills, depth, ""),)
    diameter = max(diameters)
    if len(faces) == 1 and diameter > rack.largest_drill(faces):
        mills = rack.ring_mill(diameter, faces)
        if mills:
            return (Step(mills, depth, "mill-circle", diameter),)
    return _no_tool(rack, kind, diameter, faces)


def _thread(
    rack: Rack,
    kind: HoleKind,
    diameters: tuple[float, ...],
    depth: float | None,
    faces: tuple[Face, ...],
    thickness: float,
) -> Recipe | Refusal:
    diameter = max(diameters)
    taps = rack.taps(diameter, kind == "left-thread", faces)
    if not taps:
        return _no_tool(rack, kind, diameter, faces)
    drills = rack.drills((rack.pre_drill(taps[0]),), faces)
    if not drills:
        return _no_tool(rack, kind, diameter, faces)
    drilled = None
    if depth is not None:
        # The point has to stay inside too, or a blind thread would have a hole at its end.
        drilled = depth + rack.drill.runout_pitches * taps[0].pitch
        deepest = drilled + drills[0].tip
        if thickness and deepest > thickness + ROUNDING:
            return Refusal(
                rules.THREAD_DEPTH,
                {
                    "found": f"{depth:g}",
                    "face": faces[0],
                    "expected": f"{max(0.0, thickness - (deepest - depth)):.1f}",
                },
            )
    return (Step(drills, drilled, "drill-before-tap"), Step(taps, depth, "tap-thread"))


def _sink(
    rack: Rack,
    diameters: tuple[float, ...],
    depth: float | None,
    angle: float | None,
    faces: tuple[Face, ...],
    pilot: float | None,
) -> Recipe | Refusal:
    diameter = max(diameters)
    if pilot is None:
        return Refusal(rules.NO_PILOT, {"found": f"{diameter:g}", "face": faces[0]})
    cone = angle if angle else FLAT_DEG
    if cone >= FLAT_DEG:
        tools = rack.sinks(diameter, FLAT_DEG, True, faces) if depth else ()
        steps = (Step(tools, depth, "sink-flat"),)
    else:
        slope = tan(radians(cone) / 2)
        cone_depth = (diameter - pilot) / 2 / slope
        deep = depth or cone_depth
        if deep < cone_depth - rack.drill.sink_tolerance:
            return Refusal(
                rules.SINK_DEPTH,
                {
                    "found": f"{diameter:g}",
                    "depth": f"{deep:g}",
                    "face": faces[0],
                    "expected": f"{cone_depth:.2f}",
                },
            )
        below = deep > cone_depth + rack.drill.sink_tolerance
        tools = rack.sinks(diameter, cone, below, faces)
        point = deep + pilot / 2 / slope if below else diameter / 2 / slope
        steps = (Step(tools, point, "sink-deep" if below else "sink-cone"),)
    return steps if tools else _no_tool(rack, "countersink", diameter, faces)


def _no_tool(rack: Rack, kind: str, diameter: float, faces: tuple[Face, ...]) -> Refusal:
    values = {
        "kind": kind,
        "found": f"{diameter:g}",
        "face": faces[0],
        "expected": nearest_tools(rack, kind, diameter, faces),
    }
    return Refusal(rules.NO_TOOL, values)


def nearest_tools(rack: Rack, kind: str, diameter: float, faces: tuple[Face, ...]) -> str:
    """The tools that the machine has instead, for a message."""
    if kind in ("thread", "left-thread"):
        taps = [f"M{t.diameter:g}" for t in rack.of_kind("tap", faces) if t.hand == "right"]
        return f"one of {', '.join(taps)}" if taps else "none, the machine has no tap"
    if kind == "countersink":
        sinks = sorted({t.diameter for t in rack.of_kind("countersink", faces)})
        shown = ", ".join(f"{d:g}" for d in sinks)
        return f"one that the countersinks {shown} make" if sinks else "none, it has no countersink"
    near = sorted((abs(t.diameter - diameter), t.diameter) for t in rack.of_kind("drill", faces))
    if not near:
        return "none, the machine has no drill"
    return "a hole near a drill of " + " or ".join(f"{d:g}" for _, d in near[:2])
