"""Depths of machined features in the steel: of the full diameter, not of the tool's point.

|\\        /|   drill      to the shoulder of its point; through, once that has passed the wall
| \\      / |   sink       of the cone within the steel: what is in the pilot hole cuts nothing
|  |    |  |   tap, mill  of the tip
"""

from collections.abc import Iterable
from math import radians, tan

from beamcam.machine.machine import Machine
from beamcam.machine.tools import FLAT_DEG
from beamcam.model.part import Profile
from beamcam.verify.bars.machined_features import Bore, MachinedPath
from beamcam.verify.bars.tools import ToolCatalogue

SAME_PLACE = 0.5  #: mm between a sink and its pilot hole


class SteelDepths:
    """Depths of what a program makes on a bar."""

    def __init__(self, machine: Machine, profile: Profile, bores: Iterable[Bore]) -> None:
        self._tools = ToolCatalogue(machine, machine.drill) if machine.drill is not None else None
        self._profile, self._noise = profile, 2 * machine.format.resolution
        self._pilots: dict[tuple[str, int, int], float] = {}
        for bore in bores:
            if bore.kind == "drill":
                key = _place(bore)
                self._pilots[key] = max(self._pilots.get(key, 0.0), bore.diameter)

    def of(self, op: Bore | MachinedPath) -> float | None:
        """The depth of one in the steel, mm; None where it goes through the wall."""
        thickness = self._profile.thickness(op.face)
        depth = self._bore(op) if isinstance(op, Bore) else op.max_depth
        is_through = op.kind in ("drill", "tap", "mill") and thickness > 0.0
        return None if is_through and depth > thickness - self._noise else depth

    def _bore(self, bore: Bore) -> float:
        if self._tools is None or bore.kind not in ("drill", "countersink"):
            return bore.tip_depth
        if bore.kind == "drill":
            return bore.tip_depth - self._tools.tip("drill", bore.diameter, bore.face)
        angle = self._tools.point_deg("countersink", bore.diameter, bore.face)
        if angle >= FLAT_DEG:
            return bore.tip_depth
        pilot = self._pilots.get(_place(bore), 0.0)
        return bore.tip_depth - pilot / 2 / tan(radians(angle) / 2)


def _place(bore: Bore) -> tuple[str, int, int]:
    return bore.face, round(bore.x / SAME_PLACE), round(bore.y / SAME_PLACE)
