"""The tools that a shop has, and which of them a hole wants."""

from collections.abc import Iterator
from functools import lru_cache
from math import radians, tan

from beamcam.machine.machine import FLAT_DEG, Drill, Machine, ToolSet
from beamcam.model.part import Face, Hole, Profile

USUAL_POINT_DEG = 118.0

Wants = tuple[object, ...]  #: what a hole wants made, but for its place
Tooled = tuple[object, ...]  #: what a bore says behind its place: tool, depth, feed
#: One or two for a hole, so a list; comparing takes less than hashing all those numbers.
Fine = dict[Wants, list[Tooled]]


class Rack:
    """The tools of a machine, by kind."""

    def __init__(self, machine: Machine, drill: Drill) -> None:
        self.drill = drill
        self.kinds: dict[str, tuple[ToolSet, ...]] = {}
        for tools in machine.tools:
            self.kinds[tools.kind] = (*self.kinds.get(tools.kind, ()), tools)
        self.faces = tuple(s.face for s in machine.spindles)
        self.drills = lru_cache(4096)(self._drill)
        self.plain = lru_cache(4096)(self._plain)
        self.sizes = lru_cache(64)(self._sizes)
        self._fine: dict[tuple[Profile, str], Fine] = {}
        self._count = 0
        self.twice = drill.duplicate_tolerance + 1e-9  #: holes nearer than this are one

    def of(self, kind: str, face: Face) -> Iterator[ToolSet]:
        return (t for t in self.kinds.get(kind, ()) if face in t.faces)

    def _sizes(self, kind: str, face: Face) -> frozenset[float]:
        """Diameters of the tools of a kind that the spindle of a face takes."""
        return frozenset(d for tools in self.of(kind, face) for d in tools.sizes)

    def fine(self, profile: Profile, grade: str) -> Fine:
        """What was found right on a section of a grade: for each kind of hole what made it."""
        if len(self._fine) >= 256:
            self._fine.clear()
        return self._fine.setdefault((profile, grade), {})

    def remember(self, fine: Fine, hole: Wants, tool: Tooled) -> None:
        """Note what agrees, so that it is not judged again; a few thousand at most."""
        if self._count >= 4096:
            self._fine.clear()
            self._count = 0
        self._count += 1
        fine.setdefault(hole, []).append(tool)

    def fit(self, diameter: float) -> tuple[float, float] | None:
        """Least and greatest drill for a hole; None if the machine says nothing of that size."""
        for row in self.drill.fits:
            if diameter <= row.up_to:
                return diameter - row.minus - 1e-6, diameter + row.plus + 1e-6
        return None

    def _drill(self, diameter: float, face: Face) -> float | None:
        """The drill that a hole wants: the nearest, of two equally near the smaller."""
        limits = self.fit(diameter)
        if limits is None:
            return None
        sizes = [
            (abs(d - diameter), d)
            for tools in self.of("drill", face)
            for d in tools.sizes
            if limits[0] <= d <= limits[1]
        ]
        return min(sizes)[1] if sizes else None

    def _plain(self, diameter: float, face: Face) -> tuple[str, float] | None:
        """A plain hole as messages call it, and the drill that it wants; None if there is none."""
        drill = self.drills(diameter, face)
        return None if drill is None else (f"hole {diameter:g}", drill)

    def tap(self, hole: Hole) -> tuple[float, float, float] | None:
        """Diameter and pitch of the tap that a thread wants, and the drill before it."""
        hand = "left" if hole.kind == "left-thread" else "right"
        for tools in self.of("tap", hole.face):
            if tools.hand == hand:
                for size, pitch, before in zip(
                    tools.sizes, tools.pitches, tools.pre_drills, strict=True
                ):
                    if abs(size - hole.diameter) <= self.drill.twin:
                        return size, pitch, before
        return None

    def tip(self, kind: str, diameter: float, face: Face) -> float:
        """Length of a tool's point: radius / tan(half the angle); 0 of a flat one."""
        angle = self.point_deg(kind, diameter, face)
        return 0.0 if angle >= FLAT_DEG else diameter / 2 / tan(radians(angle) / 2)

    def point_deg(self, kind: str, diameter: float, face: Face) -> float:
        """Angle of the point of the shop's tool of a diameter; a usual drill's if it has none."""
        angles = (t.point_deg for t in self.of(kind, face) if diameter in t.sizes)
        return next(angles, USUAL_POINT_DEG)

    def milled(self, diameter: float, face: Face) -> bool:
        """Whether a hole is milled as a circle: no drill is as large, and a mill may."""
        drills = [d for tools in self.of("drill", face) for d in tools.sizes]
        largest = max((t.largest_hole for t in self.of("mill", face)), default=0.0)
        return max(drills, default=0.0) < diameter <= largest
