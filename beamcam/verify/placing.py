"""Where the parts lie on the bar, by the program's own cuts.

    | start cut |# part 1 ######/ end cut | parting cut |# part 2 ####| parting cut

A square start is made by the cut that parts it from what lies before it, a skew end has a cut of
its own and a square one behind it that removes the wedge. The blade is always on the waste side.
"""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine, Saw
from beamcam.model.part import Part
from beamcam.verify import rules
from beamcam.verify.made import Cut
from beamcam.verify.need import End, ends_of

NEAR = 60.0  #: mm; a cut this near to where it should be is taken for it, in the wrong place


class Placing:
    """The starts of the parts on the bar, and what is wrong with the cuts."""

    def __init__(self, cuts: Sequence[Cut], machine: Machine, saw: Saw, name: str) -> None:
        self.machine, self.saw, self.name = machine, saw, name
        self.left = sorted(cuts, key=lambda c: (c.x, c.line))
        self.tolerance = machine.format.resolution + 1e-6
        self.angle_tolerance = 0.5 * 10.0**-machine.format.angle_decimals + 1e-6
        self.starts: list[float] = []
        self.last_cut: list[int | None] = []  #: line of the cut that parts each part
        self.said: list[Diagnostic] = []

    def place(self, parts: Sequence[Part]) -> None:
        """Find every part's cuts, in the order given; what is left over is too much."""
        ends = [ends_of(part, self.saw) for part in parts]
        begin: float | None = None  #: where the last parting cut lets the next part begin
        for index, part in enumerate(parts):
            following = ends[index + 1][0] if index + 1 < len(parts) else None
            begin = self._place(part, ends[index], following, begin)
        for cut in self.left:
            self.said.append(
                rules.CUT_EXTRA.at(
                    Source(self.name, cut.line), angle=f"{cut.angle:g}", x=f"{cut.x:g}"
                )
            )

    def _place(
        self, part: Part, ends: tuple[End, End], following: End | None, begin: float | None
    ) -> float:
        first, last = ends
        height, kerf = part.profile.height, self.saw.kerf
        if begin is not None and not first.angle:
            start = begin
        else:
            start = self._start(part, ends, begin)
            self._take(first, start + first.blade(self.saw, height), first.angle, part)
        self.starts.append(start)
        square = end_of_wedge = start + part.length + kerf / 2
        parting: Cut | None = None
        if last.angle:
            self._take(last, start + last.blade(self.saw, height), last.angle, part)
            if following is not None and not following.angle:
                # It makes the next start too, which may lie further on to spare the mitre.
                behind = [
                    c for c in self._with_angle(0.0)
                    if c.x - self.saw.x >= square - self.tolerance
                ]  # fmt: skip
                end_of_wedge = behind[0].x - self.saw.x if behind else square
        parting = self._take(last._replace(angle=0.0), end_of_wedge, 0.0, part)
        self.last_cut.append(parting.line if parting else None)
        at = parting.x - self.saw.x if parting else square
        return at + kerf / 2

    def _with_angle(self, angle: float) -> Iterator[Cut]:
        """The cuts that are left and have DSTV's `angle`, in order of X."""
        counted = self._counted(angle)
        return (c for c in self.left if abs(c.angle - counted) <= self.angle_tolerance)

    def _counted(self, angle: float) -> float:
        return self.saw.square + self.saw.angle_sign * angle

    def _start(self, part: Part, ends: tuple[End, End], begin: float | None) -> float:
        """The start of a part: where its first cut fits one at its other end, if there is any."""
        height = part.profile.height
        at, reach = (e.blade(self.saw, height) for e in ends)
        found = [c.x - self.saw.x - at for c in self._with_angle(ends[0].angle)]
        for start in found:
            if any(
                abs(c.x - self.saw.x - start - reach) <= self.tolerance
                for c in self._with_angle(ends[1].angle)
            ):
                return start
        others = [c.x - self.saw.x - reach for c in self._with_angle(ends[1].angle)]
        near = begin
        if near is None and self.machine.layout is not None:
            near = self.machine.layout.front_trim
        return min((*found, *others), key=lambda s: abs(s - (near or 0.0)), default=near or 0.0)

    def _take(self, end: End, bar_x: float, angle: float, part: Part) -> Cut | None:
        """The cut at `bar_x`, taken from those that are left; what is wrong with it is said."""
        x = bar_x + self.saw.x
        counted = self._counted(angle)
        right = [c for c in self._with_angle(angle) if abs(c.x - x) <= NEAR]
        best = min(right, key=lambda c: abs(c.x - x), default=None)
        if best is None or abs(best.x - x) > self.tolerance:
            here = [c for c in self.left if abs(c.x - x) <= self.tolerance]
            if here:
                best = min(here, key=lambda c: abs(c.angle - counted))
                self.said.append(
                    rules.CUT_ANGLE.at(
                        Source(self.name, best.line),
                        found=f"{best.angle:g}",
                        end=end.name,
                        mark=part.mark,
                        expected=f"{counted:g}",
                    )
                )
            elif best is not None:
                self.said.append(
                    rules.CUT_PLACE.at(
                        Source(self.name, best.line),
                        end=end.name,
                        mark=part.mark,
                        found=f"{best.x:.6g}",
                        expected=f"{x:.6g}",
                    )
                )
            else:
                self.said.append(
                    rules.CUT_MISSING.at(
                        part.source,
                        angle=f"{counted:g}",
                        x=f"{x:.6g}",
                        end=end.name,
                        mark=part.mark,
                    )
                )
        if best is not None:
            self.left.remove(best)
        return best
