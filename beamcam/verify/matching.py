"""Which bore makes which hole: each at most one of the others, in its place.

Several holes may be at one place, such as a wider one that goes less deep, or a thread beside a
hole of its drill's size. Of those that the output cannot tell apart by their place the one of the
tool's size is meant, then the nearest, then the one of the depth. Strokes of two spindles choose
first, since they need a hole on either side, and what follows a drill chooses last.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from math import floor
from typing import NamedTuple

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Part
from beamcam.verify import rules
from beamcam.verify.made import Bore
from beamcam.verify.needs import Stroke
from beamcam.verify.placing import NEAR
from beamcam.verify.rack import Rack

NOUNS = {"drill": "hole", "tap": "thread", "countersink": "countersink", "punch": "punch mark"}


def x_tolerance(resolution: float) -> float:
    """How far a bore may be off in X: by half a step, and the cut that the part starts at too."""
    return resolution + 1e-6


def y_tolerance(resolution: float) -> float:
    """How far a bore may be off across the bar."""
    return 0.75 * resolution + 1e-6


class Wanted(NamedTuple):
    """A stroke that a part needs, where the machine has to make it."""

    need: Stroke
    x: float  #: machine X


class Match(NamedTuple):
    """A stroke that is wanted and the bore that makes it."""

    need: Stroke
    bore: Bore
    size: float  #: the hole's diameter, of two that are drilled at once the greater


class Matching:
    """Bores and strokes.

    Strokes wait in pockets of 1 mm of X by face and tool, so that a bore looks at one or two.
    """

    def __init__(
        self, wanted: Sequence[Wanted], parts: Sequence[Part], resolution: float, rack: Rack,
        name: str,
    ) -> None:  # fmt: skip
        self.parts, self.rack, self.name = parts, rack, name
        self.merge = rack.drill.merge_tolerance
        self.x_tolerance, self.y_tolerance = x_tolerance(resolution), y_tolerance(resolution)
        self.pockets: dict[tuple[str, str, int], list[Wanted]] = {}
        self.drilled: set[tuple[str, float, float]] = set()
        for want in wanted:
            key = want.need.hole.face, want.need.kind, floor(want.x)
            if key in self.pockets:
                self.pockets[key].append(want)
            else:
                self.pockets[key] = [want]

    def run(self, bores: Sequence[Bore], said: list[Diagnostic]) -> Iterator[Match]:
        """The matches; what lies elsewhere, is missing or too much goes to `said`."""
        pairs: list[Sequence[Bore]] = []
        alone: list[Sequence[Bore]] = []
        after: list[Sequence[Bore]] = []
        for group in _strokes(bores):
            if group[0].kind != "drill":
                after.append(group)
            else:
                (alone if len(group) == 1 else pairs).append(group)
        astray: list[Bore] = []
        for group in pairs:
            yield from self._merged(group, astray, said)
        for (bore,) in alone:
            want = self._take(bore)
            if want is None:
                astray.append(bore)
            else:
                self.drilled.add((bore.face, bore.x, bore.y))
                yield Match(want.need, bore, want.need.hole.diameter)
        for group in sorted(after, key=len, reverse=True):
            yield from self._merged(group, astray, said)
        for bore in astray:
            yield from self._astray(bore, said)
        said += self._missing()

    def _merged(
        self, group: Sequence[Bore], astray: list[Bore], said: list[Diagnostic]
    ) -> Iterator[Match]:
        """The matches of strokes that may stand between two holes: of two spindles at once, and
        those that follow a drill, which stand where that one was."""
        found = self._take_all(group)
        wants = [w for w in found if w is not None]
        size = max((w.need.hole.diameter for w in wants), default=0.0)
        for bore, want in zip(group, found, strict=True):
            if want is None:
                astray.append(bore)
                continue
            if not self._between(bore, wants):
                said.append(self._elsewhere(bore, want))
            self.drilled.add((bore.face, bore.x, bore.y))
            yield Match(want.need, bore, size)

    def _astray(self, bore: Bore, said: list[Diagnostic]) -> Iterator[Match]:
        """The match of a bore that is in the wrong place, or that belongs to nothing."""
        want = self._nearest(bore)
        if want is None:
            noun = NOUNS.get(bore.kind, bore.kind)
            said.append(
                rules.HOLE_EXTRA.at(
                    Source(self.name, bore.line), what=f"{noun} {bore.diameter:g}",
                    face=bore.face, x=f"{bore.x:g}", y=f"{bore.y:g}",
                )
            )  # fmt: skip
        else:
            self._remove(want)
            said.append(self._elsewhere(bore, want))
            yield Match(want.need, bore, want.need.hole.diameter)

    def _missing(self) -> Iterator[Diagnostic]:
        for left in self.pockets.values():
            for want in left:
                if not want.need.optional:
                    hole = want.need.hole
                    yield rules.HOLE_MISSING.at(
                        hole.source,
                        what=want.need.what,
                        face=hole.face,
                        mark=self.parts[want.need.part].mark,
                        x=f"{hole.x:g}",
                        y=f"{hole.y:g}",
                        machine_x=f"{want.x:g}",
                    )

    def _take(self, bore: Bore) -> Wanted | None:
        """The stroke that a bore alone makes, of those that are left; it is taken."""
        near = self._near(bore, 0.0)
        if not near:
            return None
        best = near[0] if len(near) == 1 else min(near, key=lambda want: self._apart(want, bore))
        self._remove(best)
        return best

    def _take_all(self, group: Sequence[Bore]) -> list[Wanted | None]:
        """The strokes that the bores of a group make, those that go best together."""
        near: list[Sequence[Wanted | None]] = [
            self._near(bore, self.merge) or (None,) for bore in group
        ]
        best = min(product(*near), key=lambda wants: self._asunder(wants, group))
        for want in best:
            if want is not None:
                self._remove(want)
        return list(best)

    def _near(self, bore: Bore, reach: float) -> list[Wanted]:
        """The strokes within reach of a bore, of those that are left."""
        x_reach, y_reach = reach + self.x_tolerance, reach + self.y_tolerance
        x, y = bore.x, bore.y
        least, greatest = floor(x - x_reach), floor(x + x_reach)
        near: list[Wanted] = []
        # Seldom is there more than one millimetre to look at.
        for key in (least,) if least == greatest else range(least, greatest + 1):
            for want in self.pockets.get((bore.face, bore.kind, key), ()):
                if abs(want.x - x) <= x_reach and abs(want.need.hole.y - y) <= y_reach:
                    near.append(want)
        return near

    def _apart(self, want: Wanted, bore: Bore) -> tuple[float, float, float]:
        """How far a bore's tool is from the one wanted, its place, and its depth."""
        need = want.need
        off = abs(want.x - bore.x) + abs(need.hole.y - bore.y)
        return abs(need.diameter - bore.diameter), round(off, 6), self._deeper(want, bore)

    def _deeper(self, want: Wanted, bore: Bore) -> float:
        """How much deeper or less deep a bore goes than its hole."""
        hole = want.need.hole
        depth = hole.depth
        if depth is None:
            depth = self.parts[want.need.part].profile.thickness(hole.face)
        tip = self.rack.tip("drill", bore.diameter, bore.face) if bore.kind == "drill" else 0.0
        return abs(bore.tip_depth - tip - depth)

    def _asunder(
        self, wants: Sequence[Wanted | None], group: Sequence[Bore]
    ) -> tuple[float, float, float, float]:
        """How far a group is from the middle of what it may make, and how unlike that is."""
        made = [(w, bore) for w, bore in zip(wants, group, strict=True) if w is not None]
        if not made:
            return 0.0, 0.0, 0.0, 0.0
        count, bore = len(made), group[0]
        x = sum(w.x for w, _ in made) / count
        y = sum(w.need.hole.y for w, _ in made) / count
        sizes = [w.need.hole.diameter for w, _ in made]
        off = round(abs(x - bore.x) + abs(y - bore.y), 6)
        return (
            max(0.0, off - self.x_tolerance - self.y_tolerance),
            max(sizes) - min(sizes) + sum(abs(w.need.diameter - b.diameter) for w, b in made),
            off,
            sum(self._deeper(w, b) for w, b in made),
        )

    def _remove(self, want: Wanted) -> None:
        self.pockets[want.need.hole.face, want.need.kind, floor(want.x)].remove(want)

    def _between(self, bore: Bore, wants: Sequence[Wanted]) -> bool:
        """Whether a stroke lies on its hole, between the two that it makes, or where one is."""
        xs, ys = [w.x for w in wants], [w.need.hole.y for w in wants]
        return (
            min(xs) - self.x_tolerance <= bore.x <= max(xs) + self.x_tolerance
            and min(ys) - self.y_tolerance <= bore.y <= max(ys) + self.y_tolerance
        ) or (bore.kind != "drill" and (bore.face, bore.x, bore.y) in self.drilled)

    def _nearest(self, bore: Bore) -> Wanted | None:
        """The stroke of its face and tool that a bore may have been meant for."""
        near = [
            (abs(w.x - bore.x) + abs(w.need.hole.y - bore.y), i, w)
            for (face, kind, _), left in self.pockets.items()
            if face == bore.face and kind == bore.kind
            for i, w in enumerate(left)
            if abs(w.x - bore.x) <= NEAR and abs(w.need.hole.y - bore.y) <= NEAR
        ]
        return min(near, key=lambda n: n[:2])[2] if near else None

    def _elsewhere(self, bore: Bore, want: Wanted) -> Diagnostic:
        hole = want.need.hole
        return rules.HOLE_PLACE.at(
            Source(self.name, bore.line),
            what=want.need.what,
            face=hole.face,
            mark=self.parts[want.need.part].mark,
            found_x=f"{hole.x + bore.x - want.x:.6g}",
            found_y=f"{bore.y:.6g}",
            x=f"{hole.x:g}",
            y=f"{hole.y:g}",
        )


def _strokes(bores: Sequence[Bore]) -> Iterator[Sequence[Bore]]:
    """The bores of each stroke, one or those of two spindles at once, which follow each other."""
    begin = 0
    before: Bore | None = None
    for end, bore in enumerate(bores):
        if before is not None and (bore.line != before.line or bore.spindle != before.spindle):
            yield bores[begin:end]
            begin = end
        before = bore
    if before is not None:
        yield bores[begin:]
