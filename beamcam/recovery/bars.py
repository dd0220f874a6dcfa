"""The parts of a bar: what lies between the cuts, with what is made in it.

    | trim |# part 1 ######/ wedge | part 2 ####|  remnant

A piece between a square cut and a skew one that comes to nothing at a corner is the wedge behind a
skew end; what lies before the first cut is trim, what lies behind the last the remnant.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import isnan, nan, radians, tan

from msgspec.structs import replace

from beamcam.checks.bars import run
from beamcam.checks.bars.compare import Comparison, RequiredParts
from beamcam.checks.bars.pieces import CutPlane, SawnPiece, pieces, planes
from beamcam.checks.bars.stations import Bore, MachinedFeatures, MachinedPath
from beamcam.checks.bars.targets import slot_corners
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Machine, drill_of, text_x
from beamcam.machine.stations import FLAT_DEG, Saw
from beamcam.model.part import EndCuts, Face, Feature, Hole, Part, Profile, Slot, TextMark
from beamcam.model.section import corners, sections
from beamcam.recovery.found import (
    CATALOGUE,
    FACES,
    NO_PIECE,
    PATH,
    PROFILE,
    KnownStock,
    Recovered,
    plain,
)
from beamcam.recovery.paths import NotAFeature, feature_of

# --- holes ----------------------------------------------------------------------------------------

# Holes from what spindles made: several tools at one place are one hole, or a hole and its sink.
#
# drill                  a hole, through where the full diameter reaches the far side, else blind
# drill and tap          a thread
# countersink            a sink in the hole that is there
# punch                  a mark


LEFT = 4  #: the M word that turns a spindle counter-clockwise


def holes_of(
    bores: Sequence[Bore], led: Sequence[Feature], tools: ToolCatalogue, profile: Profile, name: str
) -> list[Hole]:
    """The holes of a part; x counts from its start. Those at the ends of slots are theirs."""
    taps = [b for b in bores if b.kind == "tap"]
    drills = [
        b for b in bores
        if b.kind == "drill" and not any(_is_at(b, t.face, t.x, t.y, tools) for t in taps)
        and not any(isinstance(s, Slot) and _is_of_slot(b, s, tools) for s in led)
    ]  # fmt: skip
    sinks = [b for b in bores if b.kind == "countersink"]
    make = _Maker(tools, profile, name)
    holes = [make.drilled(b) for b in drills]
    holes += [make.thread(b) for b in taps]
    holes += [
        make.sink(b, [p for p in (*drills, *taps) if _is_at(p, b.face, b.x, b.y, tools)])
        for b in sinks
    ]
    holes += [make.mark(b) for b in bores if b.kind == "punch"]
    return sorted(holes, key=lambda h: h.source.line or 0)


class _Maker:
    """Makes holes out of what tools did."""

    def __init__(self, tools: ToolCatalogue, profile: Profile, name: str) -> None:
        self.tools, self.profile, self.name = tools, profile, name
        form = tools.machine.format
        self.slack, self.decimals = form.resolution, form.length_decimals

    def drilled(self, bore: Bore) -> Hole:
        depth = bore.tip_depth - self.tools.tip("drill", bore.diameter, bore.face)
        deep = self._depth(depth, self.profile.thickness(bore.face))
        return self._hole(bore, bore.diameter, deep, "through" if deep is None else "blind")

    def thread(self, bore: Bore) -> Hole:
        hands = {
            t.hand for t in self.tools.of("tap", bore.face)
            if (bore.diameter, bore.pitch) in zip(t.sizes, t.pitches, strict=False)
        }  # fmt: skip
        left = hands == {"left"} or ("left" in hands and bore.turning == LEFT)
        depth = self._depth(bore.tip_depth, self.profile.thickness(bore.face))
        return self._hole(bore, bore.diameter, depth, "left-thread" if left else "thread")

    def sink(self, bore: Bore, below: Sequence[Bore]) -> Hole:
        """A countersink: its tool's cone to where that stands in the surface, or below it."""
        cones = [t.point_deg for t in self.tools.of("countersink", bore.face)
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
        usual = abs(depth - self.tools.drill.punch_depth) <= self.slack
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


def _is_at(bore: Bore, face: str, x: float, y: float, tools: ToolCatalogue) -> bool:
    near = tools.drill.merge_tolerance + 2 * tools.machine.format.resolution
    return bore.face == face and abs(bore.x - x) <= near and abs(bore.y - y) <= near


def _is_of_slot(bore: Bore, slot: Slot, tools: ToolCatalogue) -> bool:
    """Whether a drilled hole is the end of a slot, whose width was measured from a mill's path."""
    _, most = tools.fit(slot.diameter) or (0.0, slot.diameter)
    most += tools.drill.path_tolerance + 2 * tools.machine.format.resolution
    return bore.diameter <= most and any(
        _is_at(bore, slot.face, x, y, tools) for x, y in slot_corners(slot)
    )


# --- section --------------------------------------------------------------------------------------

# The section of a bar, as far as a program gives it.


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
    same = [p for code in codes for p in _of_size(code, height, width)]
    size = " x ".join(f"{v:g}" for v in (height, width) if not isnan(v))
    figures = {"code": " or ".join(codes), "size": size or "unknown size"}
    if len(same) == 1:
        return same[0], CATALOGUE.at(Source(name), name=same[0].name, **figures)
    known = ", ".join(p.name for p in same[:SHOWN]) or "none of that size in the catalogue"
    if len(same) > SHOWN:
        known += f" and {len(same) - SHOWN} more"
    height, width = (0.0 if isnan(v) else v for v in (height, width))
    profile = Profile(codes[0], "", height, width, 0.0, None)  # type: ignore[arg-type]
    return profile, PROFILE.at(Source(name), known=known, **figures)


def _of_size(code: str, height: float, width: float) -> Iterator[Profile]:
    """The catalogue's sections of a size; any width where none is said."""
    for name, (own, (h, b, flange, web, radius)) in sections().items():
        if own == code and abs(h - height) <= SAME and (isnan(width) or abs(b - width) <= SAME):
            yield Profile(own, name, h, b, flange, web, radius)


NEAR_NOTHING = 2  #: resolutions; a piece as short as that at a corner is a wedge


def recover_bars(text: str, machine: Machine, name: str, stock: KnownStock) -> Recovered:
    """The parts of a bar, in their order along it."""
    saw, drill = machine.saw, drill_of(machine)
    if saw is None:  # the parts come in cut, so that no program says where they end
        return Recovered((), (NO_PIECE.at(Source(name), cuts=0),))
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
    diagnostics += [FACES.at(Source(name), found=face) for face in done.unseen]
    pieces = _bar_pieces(done.made, machine, saw, profile)
    if not pieces:
        diagnostics.append(NO_PIECE.at(Source(name), cuts=len(done.made.cuts)))
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
    """The parts of one bar; `stated` is what is not a feature of any part."""

    def __init__(
        self, machine: Machine, tools: ToolCatalogue, saw: Saw, profile: Profile, name: str
    ) -> None:
        self.machine, self.tools, self.saw = machine, tools, saw
        self.profile, self.name = profile, name
        self.lift = profile.height if saw.pivot == "o" else 0.0
        self.diagnostics: list[Diagnostic] = []

    def part(self, piece: SawnPiece, made: MachinedFeatures, stock: KnownStock) -> Part:
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

    def _features(
        self, piece: SawnPiece, first: float, made: MachinedFeatures
    ) -> tuple[Feature, ...]:
        from_x = first + self.tools.drill.x
        paths = [self._path(t, from_x) for t in made.paths if self._in(piece, t.face, t.points[0])]
        led = [f for f in paths if f is not None]
        bores = [b for b in made.bores if self._in(piece, b.face, (b.x, b.y))]
        form = self.machine.format
        here = [
            replace(b, x=plain(b.x - from_x, form.resolution, form.length_decimals)) for b in bores
        ]
        texts = self._texts(piece, first, made)
        return (*holes_of(here, led, self.tools, self.profile, self.name), *led, *texts)

    def _texts(self, piece: SawnPiece, first: float, made: MachinedFeatures) -> Iterator[TextMark]:
        """What a stamp or printer is told on a piece, as the unit spells it."""
        form, at = self.machine.format, text_x(self.machine)
        for t in made.texts:
            if self._in(piece, t.face, (t.x - at + self.tools.drill.x, t.y)):
                x = plain(t.x - at - first, form.resolution, form.length_decimals)
                yield TextMark(t.face, x, t.y, t.angle, t.height, t.text, Source(self.name, t.line))

    def _path(self, trail: MachinedPath, from_x: float) -> Feature | None:
        moved = replace(trail, points=tuple([(x - from_x, y) for x, y in trail.points]))
        path = feature_of(moved, self.tools, self.profile, Source(self.name, trail.line))
        if isinstance(path, NotAFeature):
            self.diagnostics.append(
                PATH.at(
                    Source(self.name, trail.line), kind=trail.kind, face=trail.face, x=path.x,
                    y=path.y,
                )
            )  # fmt: skip
            return None
        return path

    def _in(self, piece: SawnPiece, face: Face, place: Sequence[float]) -> bool:
        """Whether a place of a face lies between the cuts of a piece."""
        x, y = place[0] - self.tools.drill.x, place[1]
        if face in ("v", "h"):
            rise, z = y, self.profile.width / 2
        else:
            rise, z = (self.profile.height if face == "o" else 0.0), y
        at = (rise - self.lift, z)
        return piece.start.along(*at) < x < piece.end.along(*at)
