"""Holes from what spindles made: several tools at one place are one hole, or a hole and its sink.

drill                  a hole, through where the full diameter reaches the far side, else blind
drill and tap          a thread
countersink            a sink in the hole that is there
punch                  a mark
"""

from collections.abc import Sequence
from math import radians, tan

from beamcam.errors import Source
from beamcam.machine.tools import FLAT_DEG
from beamcam.model.part import Feature, Hole, Profile, Slot
from beamcam.recovery.found import plain
from beamcam.verify.bars.machined_features import Bore
from beamcam.verify.bars.shop import Shop
from beamcam.verify.bars.targets import slot_corners

LEFT = 4  #: the M word that turns a spindle counter-clockwise


def holes_of(
    bores: Sequence[Bore], led: Sequence[Feature], shop: Shop, profile: Profile, name: str
) -> list[Hole]:
    """The holes of a part; x counts from its start. Those at the ends of slots are theirs."""
    taps = [b for b in bores if b.kind == "tap"]
    drills = [
        b for b in bores
        if b.kind == "drill" and not any(_is_at(b, t.face, t.x, t.y, shop) for t in taps)
        and not any(isinstance(s, Slot) and _is_of_slot(b, s, shop) for s in led)
    ]  # fmt: skip
    sinks = [b for b in bores if b.kind == "countersink"]
    make = _Maker(shop, profile, name)
    found = [make.drilled(b) for b in drills]
    found += [make.thread(b) for b in taps]
    found += [make.sink(b, [p for p in (*drills, *taps) if _same(p, b, shop)]) for b in sinks]
    found += [make.mark(b) for b in bores if b.kind == "punch"]
    return sorted(found, key=lambda h: h.source.line or 0)


class _Maker:
    """Makes holes out of what tools did."""

    def __init__(self, shop: Shop, profile: Profile, name: str) -> None:
        self.shop, self.profile, self.name = shop, profile, name
        form = shop.machine.format
        self.slack, self.decimals = form.resolution, form.length_decimals

    def drilled(self, bore: Bore) -> Hole:
        depth = bore.tip_depth - self.shop.tip("drill", bore.diameter, bore.face)
        deep = self._depth(depth, self.profile.thickness(bore.face))
        return self._hole(bore, bore.diameter, deep, "through" if deep is None else "blind")

    def thread(self, bore: Bore) -> Hole:
        hands = {
            t.hand for t in self.shop.of("tap", bore.face)
            if (bore.diameter, bore.pitch) in zip(t.sizes, t.pitches, strict=False)
        }  # fmt: skip
        left = hands == {"left"} or ("left" in hands and bore.turning == LEFT)
        depth = self._depth(bore.tip_depth, self.profile.thickness(bore.face))
        return self._hole(bore, bore.diameter, depth, "left-thread" if left else "thread")

    def sink(self, bore: Bore, below: Sequence[Bore]) -> Hole:
        """A countersink: its tool's cone to where that stands in the surface, or below it."""
        cones = [t.point_deg for t in self.shop.of("countersink", bore.face)
                 if bore.diameter in t.sizes]  # fmt: skip
        cone = cones[0] if cones else FLAT_DEG
        if cone >= FLAT_DEG:
            depth = plain(bore.tip_depth, self.slack, self.decimals)
            return self._hole(bore, bore.diameter, depth, "countersink")
        slope = tan(radians(cone) / 2)
        wide = plain(2 * slope * bore.tip_depth, 2 * self.slack, self.decimals)
        if wide <= bore.diameter:
            return self._hole(bore, wide, None, "countersink", cone)
        pilot = max((b.diameter for b in below), default=0.0)
        depth = plain(bore.tip_depth - pilot / 2 / slope, self.slack, self.decimals)
        return self._hole(bore, bore.diameter, depth, "countersink", cone)

    def mark(self, bore: Bore) -> Hole:
        depth = plain(bore.tip_depth, self.slack, self.decimals)
        usual = abs(depth - self.shop.drill.punch_depth) <= self.slack
        return self._hole(bore, bore.diameter, None if usual else depth, "mark")

    def _depth(self, depth: float, thickness: float) -> float | None:
        """The depth of a hole; None if it goes through, or is unknown."""
        if not thickness or depth >= thickness - self.slack:
            return None
        return plain(depth, self.slack, self.decimals)

    def _hole(
        self, bore: Bore, diameter: float, depth: float | None, kind: str,
        angle: float | None = None,
    ) -> Hole:  # fmt: skip
        y = plain(bore.y, 0.75 * self.slack, self.decimals)
        source = Source(self.name, bore.line)
        return Hole(bore.face, bore.x, y, diameter, source, depth, kind, angle)  # type: ignore[arg-type]


def _same(a: Bore, b: Bore, shop: Shop) -> bool:
    return _is_at(a, b.face, b.x, b.y, shop)


def _is_at(bore: Bore, face: str, x: float, y: float, shop: Shop) -> bool:
    near = shop.drill.merge_tolerance + 2 * shop.machine.format.resolution
    return bore.face == face and abs(bore.x - x) <= near and abs(bore.y - y) <= near


def _is_of_slot(bore: Bore, slot: Slot, shop: Shop) -> bool:
    """Whether a drilled hole is the end of a slot, whose width was measured from a mill's path."""
    _, most = shop.fit(slot.diameter) or (0.0, slot.diameter)
    most += shop.drill.path_tolerance + 2 * shop.machine.format.resolution
    return bore.diameter <= most and any(
        _is_at(bore, slot.face, x, y, shop) for x, y in slot_corners(slot)
    )
