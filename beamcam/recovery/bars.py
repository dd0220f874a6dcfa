"""The parts of a bar: what lies between the cuts, with what is made in it.

    | trim |# part 1 ######/ wedge | part 2 ####|  remnant

A piece between a square cut and a skew one that comes to nothing at a corner is the wedge behind a
skew end; what lies before the first cut is trim, what lies behind the last the remnant.
"""

from collections.abc import Mapping, Sequence
from math import isnan, nan, radians, tan

from msgspec.structs import replace

from beamcam.checks.bars import run
from beamcam.checks.bars.compare import Comparison, RequiredParts
from beamcam.checks.bars.pieces import SawnPiece, pieces, planes
from beamcam.checks.bars.stations import Bore, MachinedFeatures, MachinedPath
from beamcam.checks.bars.targets import slot_corners
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Machine, drill_of, text_x
from beamcam.machine.stations import FLAT_DEG, Saw
from beamcam.model.part import EndCuts, Face, Feature, Hole, HoleKind, Part, Profile, Slot, TextMark
from beamcam.model.section import corners, sections
from beamcam.recovery import rules
from beamcam.recovery.paths import feature_of
from beamcam.recovery.recovered import KnownStock, Recovered, mark_of, plain

SAME = 0.05  #: mm, by which height and width that a program says may differ from the catalogue's
SHOWN = 6  #: sections of one size that are named


def section_of(
    stated: Mapping[str, float], machine: Machine, name: str
) -> tuple[Profile, Diagnostic]:
    """The section that a program says, by the catalogue if only one is of that size.

    Without thicknesses where there are several, or none; the remarks on it come second.
    """
    number = stated.get("section", nan)
    codes = machine.sections_of(number) or ("SO",)
    height, width = stated.get("height", nan), stated.get("width", nan)
    same = [
        Profile(code, section, h, b, flange, web, radius)
        for of in codes
        for section, (code, (h, b, flange, web, radius)) in sections().items()
        if code == of and abs(h - height) <= SAME and (isnan(width) or abs(b - width) <= SAME)
    ]
    size = " x ".join(f"{v:g}" for v in (height, width) if not isnan(v))
    figures = {"code": " or ".join(codes), "size": size or "unknown size"}
    if len(same) == 1:
        return same[0], rules.CATALOGUE.at(Source(name), name=same[0].name, **figures)
    known = ", ".join(p.name for p in same[:SHOWN]) or "none of that size in the catalogue"
    if len(same) > SHOWN:
        known += f" and {len(same) - SHOWN} more"
    height, width = (0.0 if isnan(v) else v for v in (height, width))
    profile = Profile(codes[0], "", height, width, 0.0, None)  # type: ignore[arg-type]
    return profile, rules.PROFILE.at(Source(name), known=known, **figures)


NEAR_NOTHING = 2  #: resolutions; a piece as short as that at a corner is a wedge


def recover_bars(text: str, machine: Machine, name: str, stock: KnownStock) -> Recovered:
    """The parts of a bar, in their order along it."""
    saw, drill = machine.saw, drill_of(machine)
    if saw is None:  # the parts come in cut, so that no program says where they end
        return Recovered((), (rules.NO_PIECE.at(Source(name), cuts=0),))
    diagnostics: list[Diagnostic] = []
    profile = stock.profile
    if profile is None:
        first = run(text, machine, None, name)
        if errors_in(first.diagnostics):
            return Recovered((), first.diagnostics)
        profile, remark = section_of(dict(first.made.section), machine, name)
        diagnostics.append(remark)
    done = run(text, machine, profile, name, (stock.grade,) if stock.grade else None)
    diagnostics += done.diagnostics
    diagnostics += [rules.FACES.at(Source(name), found=face) for face in done.unseen]
    pieces = _bar_pieces(done.made, machine, saw, profile)
    if not pieces:
        diagnostics.append(rules.NO_PIECE.at(Source(name), cuts=len(done.made.cuts)))
    if errors_in(diagnostics):
        return Recovered((), tuple(diagnostics))
    bar = _Bar(machine, ToolCatalogue(machine, drill), saw, profile, name)
    parts = tuple([bar.part(piece, done.made, stock) for piece in pieces])
    diagnostics += bar.diagnostics
    if not errors_in(diagnostics) and profile.web_thickness is not None:
        diagnostics += Comparison(
            done.made, RequiredParts(parts), bar.tools, profile, done.choices, name
        ).run()
    return Recovered(parts, tuple(diagnostics))


def _bar_pieces(
    made: MachinedFeatures, machine: Machine, saw: Saw, profile: Profile
) -> list[SawnPiece]:
    """The pieces between cuts that are not wedges: a wedge has a square cut on one side."""
    least = NEAR_NOTHING * machine.format.resolution
    lift = profile.height if saw.pivot == "o" else 0.0

    def shortest(piece: SawnPiece) -> float:
        """Of the section's corners."""
        section = [(y - lift, z) for y, z in corners(profile)]
        long = min(piece.end.along(*at) - piece.start.along(*at) for at in section)
        return long - piece.start.half_kerf - piece.end.half_kerf

    def has_square_cut(piece: SawnPiece) -> bool:
        return not all(plane.web_deg or plane.flange_deg for plane in (piece.start, piece.end))

    every = pieces(planes(made.cuts, saw, profile))
    return [piece for piece in every if not has_square_cut(piece) or shortest(piece) > least]


LEFT = 4  #: the M word that turns a spindle counter-clockwise


class _Bar:
    """Makes the parts of one bar; `diagnostics` say what is not a feature of any part.

    Several tools at one place of a part are one hole, or a hole and its sink:

        drill           a hole, through where the full diameter reaches the far side, else blind
        drill and tap   a thread
        countersink     a sink in the hole that is there
        punch           a mark
    """

    def __init__(
        self, machine: Machine, tools: ToolCatalogue, saw: Saw, profile: Profile, name: str
    ) -> None:
        self.machine, self.tools, self.profile, self.name = machine, tools, profile, name
        self.slack, self.decimals = machine.format.resolution, machine.format.length_decimals
        self.lift = profile.height if saw.pivot == "o" else 0.0
        self.diagnostics: list[Diagnostic] = []

    def part(self, piece: SawnPiece, made: MachinedFeatures, stock: KnownStock) -> Part:
        """One piece as a part."""
        start, end = piece.start, piece.end
        section = corners(self.profile)
        first = min(start.along(y - self.lift, z) for y, z in section) + start.half_kerf
        last = max(end.along(y - self.lift, z) for y, z in section) - end.half_kerf
        angle_decimals = self.machine.format.angle_decimals
        slack = 0.5 * 10.0**-angle_decimals
        angles = (start.web_deg, end.web_deg, start.flange_deg, end.flange_deg)
        cuts = EndCuts(*(plain(a, slack, angle_decimals) for a in angles))
        return Part(
            mark_of(self.name), self.profile, self._plain(last - first),
            Source(self.name, start.cut.line), grade=stock.grade, cuts=cuts,
            features=self._features(piece, first, made),
        )  # fmt: skip

    def _features(
        self, piece: SawnPiece, first: float, made: MachinedFeatures
    ) -> tuple[Feature, ...]:
        from_x = first + self.tools.drill.x
        paths = [self._path(t, from_x) for t in made.paths if self._in(piece, t.face, t.points[0])]
        milled = [feature for feature in paths if feature is not None]
        bores = [
            replace(b, x=self._plain(b.x - from_x)) for b in made.bores
            if self._in(piece, b.face, (b.x, b.y))
        ]  # fmt: skip
        texts, at = [], text_x(self.machine)
        for t in made.texts:  # as the unit spells them
            if self._in(piece, t.face, (t.x - at + self.tools.drill.x, t.y)):
                x, source = self._plain(t.x - at - first), Source(self.name, t.line)
                texts.append(TextMark(t.face, x, t.y, t.angle, t.height, t.text, source))
        return (*self._holes(bores, milled), *milled, *texts)

    def _path(self, path: MachinedPath, from_x: float) -> Feature | None:
        points = tuple([(x - from_x, y) for x, y in path.points])
        source = Source(self.name, path.line)
        feature = feature_of(replace(path, points=points), self.tools, self.profile, source)
        if feature is None:
            x, y = points[0]
            self.diagnostics.append(rules.PATH.at(source, kind=path.kind, face=path.face, x=x, y=y))
        return feature

    def _in(self, piece: SawnPiece, face: Face, place: Sequence[float]) -> bool:
        """Whether a place of a face lies between the cuts of a piece."""
        x, y = place[0] - self.tools.drill.x, place[1]
        if face in ("v", "h"):
            rise, z = y, self.profile.width / 2
        else:
            rise, z = (self.profile.height if face == "o" else 0.0), y
        at = (rise - self.lift, z)
        return piece.start.along(*at) < x < piece.end.along(*at)

    def _holes(self, bores: Sequence[Bore], milled: Sequence[Feature]) -> list[Hole]:
        """The holes of a part; x counts from its start. Those at the ends of slots are theirs."""
        slots = [feature for feature in milled if isinstance(feature, Slot)]
        taps = [b for b in bores if b.kind == "tap"]
        drills = [
            b for b in bores
            if b.kind == "drill" and not any(self._is_at(b, t.face, t.x, t.y) for t in taps)
            and not any(self._is_of_slot(b, slot) for slot in slots)
        ]  # fmt: skip
        holes = [*map(self._drilled, drills), *map(self._thread, taps)]
        for b in bores:
            if b.kind == "countersink":
                below = [p for p in (*drills, *taps) if self._is_at(p, b.face, b.x, b.y)]
                holes.append(self._sink(b, max((p.diameter for p in below), default=0.0)))
        for b in bores:
            if b.kind == "punch":
                depth = self._plain(b.tip_depth)
                usual = abs(depth - self.tools.drill.punch_depth) <= self.slack
                holes.append(self._hole(b, b.diameter, None if usual else depth, "mark"))
        return sorted(holes, key=lambda h: h.source.line or 0)

    def _is_at(self, bore: Bore, face: str, x: float, y: float) -> bool:
        gap = self.tools.drill.merge_tolerance + 2 * self.slack
        return bore.face == face and abs(bore.x - x) <= gap and abs(bore.y - y) <= gap

    def _is_of_slot(self, bore: Bore, slot: Slot) -> bool:
        """Whether a drilled hole is the end of a slot, whose width was measured from its path."""
        _, most = self.tools.fit(slot.diameter) or (0.0, slot.diameter)
        most += self.tools.drill.path_tolerance + 2 * self.slack
        return bore.diameter <= most and any(
            self._is_at(bore, slot.face, x, y) for x, y in slot_corners(slot)
        )

    def _drilled(self, bore: Bore) -> Hole:
        depth = bore.tip_depth - self.tools.tip("drill", bore.diameter, bore.face)
        deep = self._depth(depth, bore.face)
        return self._hole(bore, bore.diameter, deep, "through" if deep is None else "blind")

    def _thread(self, bore: Bore) -> Hole:
        hands = {
            t.hand for t in self.tools.of("tap", bore.face)
            if (bore.diameter, bore.pitch) in zip(t.sizes, t.pitches, strict=False)
        }  # fmt: skip
        left = hands == {"left"} or ("left" in hands and bore.turning == LEFT)
        depth = self._depth(bore.tip_depth, bore.face)
        return self._hole(bore, bore.diameter, depth, "left-thread" if left else "thread")

    def _sink(self, bore: Bore, pilot: float) -> Hole:
        """A countersink: its tool's cone to where that stands in the surface, or below it."""
        sets = self.tools.of("countersink", bore.face)
        cone = next((t.point_deg for t in sets if bore.diameter in t.sizes), FLAT_DEG)
        if cone >= FLAT_DEG:
            return self._hole(bore, bore.diameter, self._plain(bore.tip_depth), "countersink")
        slope = tan(radians(cone) / 2)
        wide = plain(2 * slope * bore.tip_depth, 2 * self.slack, self.decimals)
        if wide <= bore.diameter:
            return self._hole(bore, wide, None, "countersink", cone)
        depth = self._plain(bore.tip_depth - pilot / 2 / slope)
        return self._hole(bore, bore.diameter, depth, "countersink", cone)

    def _depth(self, depth: float, face: Face) -> float | None:
        """The depth of a hole; None if it goes through, or is unknown."""
        thickness = self.profile.thickness(face)
        through = not thickness or depth >= thickness - self.slack
        return None if through else self._plain(depth)

    def _hole(
        self, bore: Bore, diameter: float, depth: float | None, kind: HoleKind,
        angle: float | None = None,
    ) -> Hole:  # fmt: skip
        y = plain(bore.y, 0.75 * self.slack, self.decimals)
        source = Source(self.name, bore.line)
        return Hole(bore.face, bore.x, y, diameter, source, depth, kind, angle)

    def _plain(self, value: float) -> float:
        return plain(value, self.slack, self.decimals)
