"""Which tool of a machine makes a hole of a given diameter.

A drill fits if it differs from the hole by no more than the machine's tolerance for that
diameter; of those that fit the nearest is taken. Tools that differ by less than `drill.twin` are
one tool to the shop (20.64 and 13/16 in), so several may be equally near; which of them is taken
is settled over the whole bar (`planning.bar_operations`):

    hole 26.99    drills 26.9875 (1 1/16 in) and 27.00    both within 0.02 of the nearest
    hole 27.00    the same two                            one drill for both holes
"""

from collections.abc import Iterable

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.machine.absent import drill_of
from beamcam.machine.drill import Drill, Fit
from beamcam.machine.machine import Machine
from beamcam.machine.tools import Tool, ToolKind, ToolSet
from beamcam.model.part import Face

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
    """The tools of a machine by kind and face. It keeps what it was asked, and is otherwise
    immutable; `library_of` gives the same one for the same machine."""

    def __init__(self, sets: tuple[ToolSet, ...], drill: Drill) -> None:
        self.drill = drill
        self._sets = sets
        # One object for each tool, so that tools can be told apart by identity.
        self._tools = [(tools, tuple(_tools(tools))) for tools in sets]
        self._drills: BoundedCache[object, Tools] = BoundedCache("planning.drills")
        #: for `operations.hole_tools`
        self.toolings: BoundedCache[object, object] = BoundedCache("planning.toolings")

    def of_kind(self, kind: ToolKind, faces: tuple[Face, ...]) -> Tools:
        """All tools of a kind that the spindles of all of `faces` take, by diameter."""
        found = (
            tool
            for tools, members in self._tools
            if tools.kind == kind and set(faces) <= set(tools.faces)
            for tool in members
        )
        return tuple(sorted(found, key=lambda t: (t.diameter, t.point_deg, t.pitch, t.hand)))

    def drills(self, diameters: tuple[float, ...], faces: tuple[Face, ...]) -> Tools:
        """The drills for holes of all of `diameters` on all of `faces`; none if nothing fits."""
        key = diameters, faces
        known = self._drills.get(key)
        if known is None:
            fitting = self.fitting(diameters, faces)
            known = self._drills.keep(key, nearest(fitting, diameters, self.drill.twin))
        return known

    def fitting(self, diameters: tuple[float, ...], faces: tuple[Face, ...]) -> Tools:
        """All drills within the tolerance of every one of `diameters`."""
        fits = [fit_of(diameter, self.drill) for diameter in diameters]
        if None in fits:
            return ()
        return tuple(
            tool
            for tool in self.of_kind("drill", faces)
            if all(
                fit is not None and is_within(tool.diameter - diameter, fit)
                for diameter, fit in zip(diameters, fits, strict=True)
            )
        )

    def sinks(
        self, diameter: float, point_deg: float, whole: bool, faces: tuple[Face, ...]
    ) -> Tools:
        """Countersinks for an outer diameter; `whole` asks for a tool of that very diameter.

        A cone that ends at its outer diameter may be made with any larger tool, one that stands
        below the surface or a flat counterbore only with a tool that fits the diameter.
        """
        fit = fit_of(diameter, self.drill)
        cones = [
            t
            for t in self.of_kind("countersink", faces)
            if abs(t.point_deg - point_deg) <= ROUNDING
        ]
        if whole:
            fitting = [t for t in cones if fit and is_within(t.diameter - diameter, fit)]
            return nearest(tuple(fitting), (diameter,), self.drill.twin)
        return tuple(t for t in cones if t.diameter >= diameter - ROUNDING)[:1]

    def taps(self, diameter: float, left: bool, faces: tuple[Face, ...]) -> Tools:
        """The tap of a nominal diameter."""
        hand = "left" if left else "right"
        return tuple(
            tap
            for tap in self.of_kind("tap", faces)
            if tap.hand == hand and abs(tap.diameter - diameter) <= self.drill.twin
        )[:1]

    def pre_drill(self, tap: Tool) -> float:
        """Diameter of the drill before a tap."""
        return next(
            before
            for tools in self._sets
            if tools.kind == "tap" and tools.hand == tap.hand
            for size, before, pitch in zip(
                tools.sizes, tools.pre_drills, tools.pitches, strict=True
            )
            if size == tap.diameter and pitch == tap.pitch
        )

    def ring_mill(self, diameter: float, faces: tuple[Face, ...]) -> Tools:
        """The largest mill that may make a hole of `diameter` as a circle."""
        largest = max(
            (t.largest_hole for t in self._sets if t.kind == "mill" and set(faces) <= set(t.faces)),
            default=0.0,
        )
        if diameter > largest:
            return ()
        fitting = (t for t in self.of_kind("mill", faces) if t.diameter <= MILL_ROOM * diameter)
        return tuple(fitting)[-1:]

    def slot_mill(self, diameter: float, faces: tuple[Face, ...]) -> Tools:
        """The largest mill that is no wider than a slot."""
        limit = diameter + self.drill.twin
        return tuple(t for t in self.of_kind("mill", faces) if t.diameter <= limit)[-1:]

    def largest_drill(self, faces: tuple[Face, ...]) -> float:
        """Diameter of the largest drill; 0 if there is none."""
        return max((t.diameter for t in self.of_kind("drill", faces)), default=0.0)


#: The tools of a machine; none of one that does not drill.
library_of: PerObject[Machine, ToolLibrary] = PerObject(
    "planning.library", lambda machine: ToolLibrary(machine.tools, drill_of(machine))
)


def _tools(tools: ToolSet) -> Iterable[Tool]:
    pitches = tools.pitches or (0.0,) * len(tools.sizes)
    for diameter, pitch in zip(tools.sizes, pitches, strict=True):
        yield Tool(
            tools.kind, diameter, tools.point_deg, pitch, tools.hand, tools.tool_material,
            tools.max_peck,
        )  # fmt: skip


def fit_of(diameter: float, drill: Drill) -> Fit | None:
    """The tolerance for holes of a diameter; None beyond the last row."""
    fit = next((f for f in drill.fits if diameter <= f.up_to), None)
    if fit is None or not drill.never_under:
        return fit
    return replace(fit, minus=min(fit.minus, drill.twin))


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
