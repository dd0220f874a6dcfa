"""The parts of a bar: what lies between the cuts, with what is made in it.

    | trim |# part 1 ######/ wedge | part 2 ####|  remnant

A piece between a square cut and a skew one that comes to nothing at a corner is the wedge behind a
skew end; what lies before the first cut is trim, what lies behind the last the remnant.
"""

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.absent import drill_of, text_x
from beamcam.machine.machine import Machine
from beamcam.machine.saw import Saw
from beamcam.model.part import EndCuts, Face, Feature, Part, Profile, TextMark
from beamcam.model.section import corners
from beamcam.recovery import rules
from beamcam.recovery.found import Recovered, Stock, plain
from beamcam.recovery.holes import holes_of
from beamcam.recovery.paths import NotAFeature, feature_of
from beamcam.recovery.section import section_of
from beamcam.verify.bars import run
from beamcam.verify.bars.compare import Asked, Comparison
from beamcam.verify.bars.machined_features import Bore, MachinedFeatures, MachinedPath
from beamcam.verify.bars.pieces import CutPlane, Piece, pieces, planes
from beamcam.verify.bars.shop import Shop

NEAR_NOTHING = 2  #: resolutions; a piece as short as that at a corner is a wedge


def recover_bars(text: str, machine: Machine, name: str, stock: Stock) -> Recovered:
    """The parts of a bar, in their order along it."""
    saw, drill = machine.saw, drill_of(machine)
    if saw is None:  # the parts come in cut, so that no program says where they end
        return Recovered((), (rules.NO_PIECE.at(Source(name), cuts=0),))
    told: list[Diagnostic] = []
    profile = stock.profile
    if profile is None:
        first = run(text, machine, None, name)
        if errors_in(first.diagnostics):
            return Recovered((), first.diagnostics)
        profile, remark = section_of(dict(first.made.section), machine, name)
        told.append(remark)
    done = run(text, machine, profile, name, (stock.grade,) if stock.grade else None)
    told += done.diagnostics
    told += [rules.FACES.at(Source(name), found=face) for face in done.unseen]
    found = _bar_pieces(done.made, machine, saw, profile)
    if not found:
        told.append(rules.NO_PIECE.at(Source(name), cuts=len(done.made.cuts)))
    if errors_in(told):
        return Recovered((), tuple(told))
    bar = _Bar(machine, Shop(machine, drill), saw, profile, name)
    parts = tuple([bar.part(piece, done.made, stock) for piece in found])
    told += bar.said
    if not errors_in(told) and profile.web_thickness is not None:
        told += Comparison(done.made, Asked(parts), bar.shop, profile, done.choices, name).run()
    return Recovered(parts, tuple(told))


def _bar_pieces(
    made: MachinedFeatures, machine: Machine, saw: Saw, profile: Profile
) -> list[Piece]:
    """The pieces between cuts that are not wedges: a wedge has a square cut on one side."""
    least = NEAR_NOTHING * machine.format.resolution
    lift = profile.height if saw.pivot == "o" else 0.0
    return [
        piece
        for piece in pieces(planes(made.cuts, saw, profile))
        if not (_is_square(piece.start) or _is_square(piece.end))
        or min(
            piece.end.along(y - lift, z) - piece.start.along(y - lift, z)
            for y, z in corners(profile)
        )
        - piece.start.half_kerf
        - piece.end.half_kerf
        > least
    ]


def _is_square(plane: CutPlane) -> bool:
    return not plane.web_deg and not plane.flange_deg


class _Bar:
    """The parts of one bar; `said` is what is not a feature of any part."""

    def __init__(self, machine: Machine, shop: Shop, saw: Saw, profile: Profile, name: str) -> None:
        self.machine, self.shop, self.saw = machine, shop, saw
        self.profile, self.name = profile, name
        self.lift = profile.height if saw.pivot == "o" else 0.0
        self.said: list[Diagnostic] = []

    def part(self, piece: Piece, made: MachinedFeatures, stock: Stock) -> Part:
        """One piece as a part."""
        form = self.machine.format
        start, end = piece.start, piece.end
        section = corners(self.profile)
        first = min(start.along(y - self.lift, z) for y, z in section) + start.half_kerf
        last = max(end.along(y - self.lift, z) for y, z in section) - end.half_kerf
        slack = 0.5 * 10.0**-form.angle_decimals
        angles = (start.web_deg, end.web_deg, start.flange_deg, end.flange_deg)
        cuts = EndCuts(*(plain(a, slack, form.angle_decimals) for a in angles))
        length = plain(last - first, form.resolution, form.length_decimals)
        return Part(
            self.name.rpartition("/")[2].partition(".")[0] or "part",
            self.profile, length, Source(self.name, start.cut.line),
            grade=stock.grade, cuts=cuts, features=self._features(piece, first, made),
        )  # fmt: skip

    def _features(self, piece: Piece, first: float, made: MachinedFeatures) -> tuple[Feature, ...]:
        from_x = first + self.shop.drill.x
        paths = [self._path(t, from_x) for t in made.paths if self._in(piece, t.face, t.points[0])]
        led = [f for f in paths if f is not None]
        bores = [b for b in made.bores if self._in(piece, b.face, (b.x, b.y))]
        here = [replace(b, x=self._x(b, from_x)) for b in bores]
        texts = self._texts(piece, first, made)
        return (*holes_of(here, led, self.shop, self.profile, self.name), *led, *texts)

    def _texts(self, piece: Piece, first: float, made: MachinedFeatures) -> Iterator[TextMark]:
        """What a stamp or printer is told on a piece, as the unit spells it."""
        form, at = self.machine.format, text_x(self.machine)
        for t in made.texts:
            if self._in(piece, t.face, (t.x - at + self.shop.drill.x, t.y)):
                x = plain(t.x - at - first, form.resolution, form.length_decimals)
                yield TextMark(t.face, x, t.y, t.angle, t.height, t.text, Source(self.name, t.line))

    def _x(self, bore: Bore, from_x: float) -> float:
        form = self.machine.format
        return plain(bore.x - from_x, form.resolution, form.length_decimals)

    def _path(self, trail: MachinedPath, from_x: float) -> Feature | None:
        moved = replace(trail, points=tuple([(x - from_x, y) for x, y in trail.points]))
        found = feature_of(moved, self.shop, self.profile, Source(self.name, trail.line))
        if isinstance(found, NotAFeature):
            self.said.append(
                rules.PATH.at(
                    Source(self.name, trail.line), kind=trail.kind, face=trail.face, x=found.x,
                    y=found.y,
                )
            )  # fmt: skip
            return None
        return found

    def _in(self, piece: Piece, face: Face, place: Sequence[float]) -> bool:
        """Whether a place of a face lies between the cuts of a piece."""
        x, y = place[0] - self.shop.drill.x, place[1]
        if face in ("v", "h"):
            rise, z = y, self.profile.width / 2
        else:
            rise, z = (self.profile.height if face == "o" else 0.0), y
        at = (rise - self.lift, z)
        return piece.start.along(*at) < x < piece.end.along(*at)
