"""The tools that a shop has, and between which sizes a tool fits a hole."""

from collections.abc import Iterator
from math import radians, tan

from beamcam.caches import cached
from beamcam.machine.drill import Drill
from beamcam.machine.machine import Machine
from beamcam.machine.tools import FLAT_DEG, ToolSet
from beamcam.model.part import Face, Hole, Part
from beamcam.model.section import NO_PLATE

USUAL_POINT_DEG = 118.0


class Shop:
    """The tools of a machine, by kind, and the faces that its spindles reach."""

    def __init__(self, machine: Machine, drill: Drill) -> None:
        self.machine, self.drill = machine, drill
        self.kinds: dict[str, tuple[ToolSet, ...]] = {}
        for tools in machine.tools:
            self.kinds[tools.kind] = (*self.kinds.get(tools.kind, ()), tools)
        self.faces: tuple[Face, ...] = tuple(s.face for s in machine.spindles)
        self.sizes = cached("verify.sizes")(self._sizes)
        self.fits = cached("verify.fits")(self._fits)
        self.tip = cached("verify.tips")(self._tip)
        self.twice = drill.duplicate_tolerance + 1e-9  #: holes nearer than this are one

    def of(self, kind: str, face: Face) -> Iterator[ToolSet]:
        """The tools of a kind that the spindle of a face takes."""
        return (t for t in self.kinds.get(kind, ()) if face in t.faces)

    def _sizes(self, kind: str, face: Face) -> tuple[float, ...]:
        """Diameters of the tools of a kind that the spindle of a face takes, in order."""
        return tuple(sorted({d for tools in self.of(kind, face) for d in tools.sizes}))

    def fit(self, diameter: float) -> tuple[float, float] | None:
        """Minimum and maximum drill for a hole; None if the machine has no row for that size."""
        for row in self.drill.fits:
            if diameter <= row.up_to:
                under = min(row.minus, self.drill.twin) if self.drill.never_under else row.minus
                return diameter - under - 1e-6, diameter + row.plus + 1e-6
        return None

    def _fits(self, kind: str, diameter: float, face: Face) -> tuple[float, ...]:
        """The tools of a kind that fit a hole, the nearest first, of two the smaller."""
        limits = self.fit(diameter)
        if limits is None:
            return ()
        fitting = [d for d in self.sizes(kind, face) if limits[0] <= d <= limits[1]]
        return tuple(sorted(fitting, key=lambda d: (abs(d - diameter), d)))

    def tap(self, hole: Hole) -> tuple[float, float, float] | None:
        """Diameter and pitch of the tap of a thread, and the drill before it."""
        hand = "left" if hole.kind == "left-thread" else "right"
        for tools in self.of("tap", hole.face):
            if tools.hand == hand:
                for size, pitch, before in zip(
                    tools.sizes, tools.pitches, tools.pre_drills, strict=True
                ):
                    if abs(size - hole.diameter) <= self.drill.twin:
                        return size, pitch, before
        return None

    def _tip(self, kind: str, diameter: float, face: Face) -> float:
        """Length of a tool's point: radius / tan(half the angle); 0 of a flat one."""
        angle = self.point_deg(kind, diameter, face)
        return 0.0 if angle >= FLAT_DEG else diameter / 2 / tan(radians(angle) / 2)

    def point_deg(self, kind: str, diameter: float, face: Face) -> float:
        """Angle of the point of the shop's tool of a diameter; a usual drill's if it has none."""
        angles = (t.point_deg for t in self.of(kind, face) if diameter in t.sizes)
        return next(angles, USUAL_POINT_DEG)

    def mills_round(self, diameter: float, face: Face) -> bool:
        """Whether a hole may be milled as a circle: no drill is as large, and a mill may."""
        largest = max((t.largest_hole for t in self.of("mill", face)), default=0.0)
        return max(self.sizes("drill", face), default=0.0) < diameter <= largest

    def works_on(self, face: Face, part: Part) -> bool:
        """Whether a spindle works on a face of a part."""
        return face in self.faces and face not in NO_PLATE.get(part.profile.code, ())
