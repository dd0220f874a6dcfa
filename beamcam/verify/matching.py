"""Which bore makes which hole: each at most one of the others, in its place."""

from collections.abc import Iterator, Sequence
from math import floor
from typing import NamedTuple

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Part
from beamcam.verify import rules
from beamcam.verify.made import Bore
from beamcam.verify.needs import Stroke
from beamcam.verify.placing import NEAR

NOUNS = {"drill": "hole", "tap": "thread", "countersink": "countersink", "punch": "punch mark"}


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
        self, wanted: Sequence[Wanted], parts: Sequence[Part], resolution: float, merge: float,
        name: str,
    ) -> None:  # fmt: skip
        self.parts, self.name, self.merge = parts, name, merge
        self.x_tolerance = resolution + 1e-6  # of the cut that the part starts at, and its own
        self.y_tolerance = 0.75 * resolution + 1e-6
        self.pockets: dict[tuple[str, str, int], list[Wanted]] = {}
        self.drilled: set[tuple[str, float, float]] = set()
        for want in wanted:
            key = want.need.hole.face, want.need.kind, floor(want.x)
            self.pockets.setdefault(key, []).append(want)

    def run(self, bores: Sequence[Bore], said: list[Diagnostic]) -> Iterator[Match]:
        """The matches; what lies elsewhere, is missing or too much goes to `said`."""
        astray: list[Bore] = []
        for group in _strokes(bores):
            bore = group[0]
            if len(group) > 1 or bore.kind != "drill":
                yield from self._merged(group, astray, said)
                continue
            want = self._take(bore, 0.0)
            if want is None:
                astray.append(bore)
            else:
                self.drilled.add((bore.face, bore.x, bore.y))
                yield Match(want.need, bore, want.need.hole.diameter)
        for bore in astray:
            yield from self._astray(bore, said)
        said += self._missing()

    def _merged(
        self, group: Sequence[Bore], astray: list[Bore], said: list[Diagnostic]
    ) -> Iterator[Match]:
        """The matches of strokes that may stand between two holes: of two spindles at once, and
        those that follow a drill, which stand where that one was."""
        found = [self._take(bore, self.merge) for bore in group]
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

    def _take(self, bore: Bore, reach: float) -> Wanted | None:
        """The nearest stroke within reach of a bore, of those that are left; it is taken."""
        x_reach, y_reach = reach + self.x_tolerance, reach + self.y_tolerance
        x, y = bore.x, bore.y
        near: list[Wanted] = []
        for key in range(floor(x - x_reach), floor(x + x_reach) + 1):
            pocket = self.pockets.get((bore.face, bore.kind, key))
            if pocket is not None:
                near += [
                    want for want in pocket
                    if abs(want.x - x) <= x_reach and abs(want.need.hole.y - y) <= y_reach
                ]  # fmt: skip
        if not near:
            return None
        # Of two in one place the one of the tool's size is meant.
        best = near[0] if len(near) == 1 else min(near, key=lambda want: _apart(want, bore))
        self._remove(best)
        return best

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


def _apart(want: Wanted, bore: Bore) -> tuple[float, float]:
    """How far a bore is from a stroke, and its tool from the one wanted."""
    need = want.need
    off = abs(want.x - bore.x) + abs(need.hole.y - bore.y)
    return round(off, 6), abs(need.diameter - bore.diameter)


def _strokes(bores: Sequence[Bore]) -> Iterator[Sequence[Bore]]:
    """The bores of each stroke, one or those of two spindles at once, which follow each other."""
    begin = 0
    for end in range(1, len(bores) + 1):
        first = bores[begin]
        if (
            end == len(bores)
            or bores[end].line != first.line
            or bores[end].spindle != first.spindle
        ):
            yield bores[begin:end]
            begin = end
