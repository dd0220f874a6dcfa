"""Which tool of a machine makes a hole of a given diameter.

A drill fits if it differs from the hole by no more than the machine's tolerance for that
diameter; of those that fit the nearest is taken. Tools that differ by less than
`drill.same_tool_tolerance` are one tool to the shop (20.64 and 13/16 in), so several may be equally
near; which of them is taken is settled over the whole bar (`planning.beam`):

    hole 26.99    drills 26.9875 (1 1/16 in) and 27.00    both within 0.02 of the nearest
    hole 27.00    the same two                            one drill for both holes
"""

from collections.abc import Mapping
from itertools import repeat
from math import radians, tan
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic, Rule, Source, error
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine, drill_of
from beamcam.machine.stations import FLAT_DEG, Drill, Fit, Tool, ToolKind, ToolSet
from beamcam.model.part import Face, HoleKind
from beamcam.model.plan import StampedLetters
from beamcam.planning.rules import MARK, NO_TOOL, no_unit

Tools = tuple[Tool, ...]  #: equally good ones, the nearest first
ROUNDING = 1e-9  #: of decimal tolerances in binary numbers
MILL_ROOM = 0.98  #: a mill that leads round a circle is smaller than it by this at least


class Tooling(Struct, frozen=True):
    """The work of a spindle, independent of the place; most places of a part share it."""

    spindle: int
    tools: Tools  #: any of which may do it
    faces: tuple[Face, ...]
    depth: float | None  #: None is through
    reasons: tuple[str, ...]
    diameter: float = 0.0  #: of a plain hole, whose drill follows from it
    ring: float = 0.0  #: diameter of the circle that a mill leaves; 0 for a stroke


class ToolLibrary:
    """The tools of a machine by kind and face. It keeps its answers, and is otherwise
    immutable; `library_of` gives the same one for the same machine."""

    def __init__(self, sets: tuple[ToolSet, ...], drill: Drill) -> None:
        self.drill = drill
        self._sets = sets
        # One object for each tool, so that tools can be told apart by identity.
        self._tools = [
            (t, [Tool(t.kind, size, t.point_deg, pitch, t.hand, t.tool_material, t.max_peck)
                 for size, pitch in zip(t.sizes, t.pitches or repeat(0.0), strict=False)])
            for t in sets
        ]  # fmt: skip
        self._drills: BoundedCache[object, Tools] = BoundedCache("planning.drills")
        #: for `operations.hole_tools`
        self.toolings: BoundedCache[HoleWork, tuple[Tooling, ...] | Refusal] = BoundedCache(
            "planning.toolings"
        )

    def of_kind(self, kind: ToolKind, faces: tuple[Face, ...]) -> Tools:
        """All tools of a kind that the spindles of all of `faces` take, by diameter."""
        tools = (
            tool
            for tools, members in self._tools
            if tools.kind == kind and set(faces) <= set(tools.faces)
            for tool in members
        )
        return tuple(sorted(tools, key=lambda t: (t.diameter, t.point_deg, t.pitch, t.hand)))

    def drills(self, diameters: tuple[float, ...], faces: tuple[Face, ...]) -> Tools:
        """The drills for holes of all of `diameters` on all of `faces`; none if nothing fits."""
        key = diameters, faces
        known = self._drills.get(key)
        if known is None:
            fitting, twin = self.fitting(diameters, faces), self.drill.same_tool_tolerance
            known = self._drills.keep(key, nearest(fitting, diameters, twin))
        return known

    def fitting(self, diameters: tuple[float, ...], faces: tuple[Face, ...]) -> Tools:
        """All drills within the tolerance of every one of `diameters`."""
        fits = [(diameter, fit_of(diameter, self.drill)) for diameter in diameters]
        return tuple(
            tool
            for tool in self.of_kind("drill", faces)
            if all(fit and is_within(tool.diameter - diameter, fit) for diameter, fit in fits)
        )

    def sinks(
        self, diameter: float, point_deg: float, whole: bool, faces: tuple[Face, ...]
    ) -> Tools:
        """Countersinks for an outer diameter; `whole` asks for a tool of exactly that diameter.

        A cone that ends at its outer diameter may be made with any larger tool, one that stands
        below the surface or a flat counterbore only with a tool that fits the diameter.
        """
        fit = fit_of(diameter, self.drill)
        sinks = self.of_kind("countersink", faces)
        cones = [t for t in sinks if abs(t.point_deg - point_deg) <= ROUNDING]
        if whole:
            fitting = [t for t in cones if fit and is_within(t.diameter - diameter, fit)]
            return nearest(tuple(fitting), (diameter,), self.drill.same_tool_tolerance)
        return tuple(t for t in cones if t.diameter >= diameter - ROUNDING)[:1]

    def taps(self, diameter: float, left: bool, faces: tuple[Face, ...]) -> Tools:
        """The tap of a nominal diameter."""
        hand, off = "left" if left else "right", self.drill.same_tool_tolerance
        taps = (tap for tap in self.of_kind("tap", faces) if tap.hand == hand)
        return tuple(tap for tap in taps if abs(tap.diameter - diameter) <= off)[:1]

    def pre_drill(self, tap: Tool) -> float:
        """Diameter of the drill before a tap."""
        return next(
            before
            for t in self._sets
            if t.kind == "tap" and t.hand == tap.hand
            for size, before, pitch in zip(t.sizes, t.pre_drills, t.pitches, strict=True)
            if size == tap.diameter and pitch == tap.pitch
        )

    def ring_mill(self, diameter: float, faces: tuple[Face, ...]) -> Tools:
        """The largest mill that may make a hole of `diameter` as a circle."""
        mills = (t for t in self._sets if t.kind == "mill" and set(faces) <= set(t.faces))
        if diameter > max((t.largest_hole for t in mills), default=0.0):
            return ()
        return tuple(t for t in self.of_kind("mill", faces) if t.diameter <= MILL_ROOM * diameter)[
            -1:
        ]

    def slot_mill(self, diameter: float, faces: tuple[Face, ...]) -> Tools:
        """The largest mill that is no wider than a slot."""
        limit = diameter + self.drill.same_tool_tolerance
        return tuple(t for t in self.of_kind("mill", faces) if t.diameter <= limit)[-1:]


#: The tools of a machine; none of one that does not drill.
library_of: PerObject[Machine, ToolLibrary] = PerObject(
    "planning.library", lambda machine: ToolLibrary(machine.tools, drill_of(machine))
)


def fit_of(diameter: float, drill: Drill) -> Fit | None:
    """The tolerance for holes of a diameter; None beyond the last row."""
    fit = next((f for f in drill.fits if diameter <= f.up_to), None)
    if fit is None or not drill.never_under:
        return fit
    return replace(fit, minus=min(fit.minus, drill.same_tool_tolerance))


def is_within(difference: float, fit: Fit) -> bool:
    """Whether a drill may differ from its hole by this."""
    return -fit.minus - ROUNDING <= difference <= fit.plus + ROUNDING


def nearest(fitting: Tools, diameters: tuple[float, ...], twin: float) -> Tools:
    """Those of `fitting` that are nearest, and those that are as near but for a twin's difference.

    Of two that are exactly as near the smaller comes first: a hole can be reamed and not filled.
    """
    ranked = sorted(
        (max(abs(t.diameter - d) for d in diameters), t.diameter, i) for i, t in enumerate(fitting)
    )
    if not ranked:
        return ()
    limit = ranked[0][0] + twin + ROUNDING
    return tuple(fitting[i] for distance, _, i in ranked if distance <= limit)


# --- hole tools -----------------------------------------------------------------------------------

# The steps of a hole: drill, drill and tap, sink, punch, or mill round.
#
#     through, blind    one drill of a fitting diameter; a larger one a mill along a circle
#     thread            the drill before the tap, deeper by the tap's run-out, and the tap
#     countersink       its own row in DSTV, beside the row of the hole that it sinks
#     mark              a centre punch
#
# How deep a cone goes follows from its outer diameter D, its angle a and the hole d below it:
#
#     |<----- D ----->|
#     \               /   ^             a cone alone:  depth = (D - d) / 2 / tan(a / 2)
#       \    a      /     | depth       deeper: it stands below the surface, and only a tool
#         |< d  >|        v             of diameter D leaves that cylinder above it
#           tip            point of the tool: depth + d / 2 / tan(a / 2)


NO_PILOT = error("plan-countersink",
    "found a countersink of diameter {found} on face {face} at x {x}, y {y}; expected a hole to "
    "sink at that place",
    "DSTV gives a countersunk hole in two rows, the sink and the hole; one of them is "
    "missing.")  # fmt: skip
SINK_DEPTH = error("plan-sink-depth",
    "found a countersink of diameter {found} and depth {depth} on face {face}; expected a depth of "
    "at least {expected} for that cone and hole",
    "Diameter, depth, cone and hole contradict each other, and only three of them can be "
    "right.")  # fmt: skip
THREAD_DEPTH = error("plan-thread-depth",
    "found a thread of depth {found} on face {face}; expected at most {expected}, the tapping "
    "drill would come through",
    "The drill before a blind tap goes deeper than the thread by the tap's run-out.")  # fmt: skip


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
        known = library.toolings.keep(hole, _MAKERS[hole.kind](library, hole))
    return known


def _mark(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    punches = library.of_kind("punch", hole.faces)[:1]
    if not punches:
        why = no_unit("punch")
        return Refusal(MARK, {"found": "a centre punch", "face": hole.faces[0], "why": why})
    return (_step(hole, punches, hole.depth or library.drill.punch_depth, "punch-mark"),)


def _step(hole: HoleWork, tools: Tools, depth: float | None, reason: str) -> Tooling:
    return Tooling(hole.spindle, tools, hole.faces, depth, (reason, *hole.why))


def _plain(library: ToolLibrary, hole: HoleWork) -> tuple[Tooling, ...] | Refusal:
    faces, spindle, depth = hole.faces, hole.spindle, hole.depth
    drills = library.drills(hole.diameters, faces)
    if drills:
        return (Tooling(spindle, drills, faces, depth, hole.why, diameter=hole.diameters[0]),)
    diameter = max(hole.diameters)
    largest = max((drill.diameter for drill in library.of_kind("drill", faces)), default=0.0)
    if len(faces) == 1 and diameter > largest:
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


_MAKERS = {
    "through": _plain, "blind": _plain, "thread": _thread, "left-thread": _thread,
    "countersink": _sink, "mark": _mark,
}  # fmt: skip


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
    sizes = sorted(
        (t.diameter for t in library.of_kind("drill", faces)), key=lambda d: abs(d - diameter)
    )
    if not sizes:
        return "none, the machine has no drill"
    shown = " or ".join(f"{d:g}" for d in sizes[:2])
    fit = fit_of(diameter, library.drill)
    if fit is None:
        return f"a hole near a drill of {shown}"
    limits = f"{diameter - fit.minus:g} to {diameter + fit.plus:g}"
    return f"a drill of {limits} (drill.fits); the nearest are {shown}"


class WorkingStep(Struct, frozen=True):
    """One operation of a spindle, at its place on the part (the workingstep of ISO 14649)."""

    x: float
    y: float
    tooling: Tooling
    features: tuple[int, ...]  #: those of the part that it makes
    source: Source
    path: tuple[Point, ...] = ()  #: x on the part and y on the face; () for a stroke
    text: StampedLetters | None = None  #: for a stamp or printer


class Settled(Struct, frozen=True):
    """A feature that needs no working step of its own."""

    feature: int
    how: Literal["made", "duplicate", "listed"]
    by: str  #: "saw", why it is left for manual work, or the code that says why
    like: int | None = None  #: the feature that it repeats


Said = tuple[int, Diagnostic]  #: a message about a feature, by its index
Found = WorkingStep | Settled | Said
