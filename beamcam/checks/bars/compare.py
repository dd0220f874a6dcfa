"""Check that each required feature is machined exactly once, in its place, and no other.

cuts -> pieces of bar -> parts;  holes, pockets and lines of each part -> what made them
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from math import isnan
from typing import TYPE_CHECKING

from msgspec import Struct, field

from beamcam.checks import rules
from beamcam.checks.bars.ability import FeatureRef, may_be_missing, repeats
from beamcam.checks.bars.cuts import CutFaults
from beamcam.checks.bars.holes import HoleCheck, RequiredHole
from beamcam.checks.bars.machine_limits import reach_faults, section_faults, shape_of, steel_faults
from beamcam.checks.bars.orientations import orientations
from beamcam.checks.bars.paths import PathsAlong, RequiredPath, check_paths, entry_faults, is_led
from beamcam.checks.bars.pieces import (
    Candidate,
    LaidPart,
    RequiredEnd,
    ends_of,
    lay_out,
    overlapping,
    pieces,
    planes,
    wedge_cuts,
)
from beamcam.checks.bars.stations import Choice, MachinedFeatures
from beamcam.checks.bars.targets import (
    RequiredPocket,
    RequiredRound,
    Target,
    Unmakeable,
    targets_of,
)
from beamcam.checks.bars.tools import Done, ToolCatalogue, parting_faults
from beamcam.checks.job import left_out, left_to_manual_work
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine, saw_of
from beamcam.model.part import Part, Profile, TextMark

if TYPE_CHECKING:
    from beamcam.checks.bars.texts import PrintedTexts


class RequiredParts(Struct, frozen=True):
    """The required parts."""

    parts: Sequence[Part]
    skips: Collection[str] = ()
    free: bool = False  #: whether the parts may lie in another order
    turn: bool = False
    bar: float | None = None


class _Required(Struct):
    """What the parts on a bar require; features are a part and its feature, by their indices."""

    holes: list[RequiredHole] = field(default_factory=list)
    led: list[RequiredPath] = field(default_factory=list)
    optional: set[FeatureRef] = field(default_factory=set)  #: that may be missing
    missing: set[FeatureRef] = field(default_factory=set)  #: those that are


class Comparison:
    """Comparison of one program with the required parts; `said` holds its faults."""

    def __init__(
        self, made: MachinedFeatures, job: RequiredParts, tools: ToolCatalogue, profile: Profile,
        choices: dict[int, Choice], name: str,
    ) -> None:  # fmt: skip
        self.made, self.asked, self.tools, self.saw = made, job, tools, saw_of(tools.machine)
        self.machine: Machine = tools.machine
        self.profile, self.name = profile, name
        self.targets: dict[int, list[Target]] = {}
        self.holes = HoleCheck(made.bores, tools, profile, choices, name)
        self.cuts = planes(made.cuts, self.saw, profile)
        self.laid: list[LaidPart] = []  #: the parts, once they are found
        self.diagnostics: list[Diagnostic] = [
            *_section(made, profile, self.machine, name),
            *section_faults(profile, self.machine, name),
            *reach_faults(made.cuts, profile, self.machine, name),
        ]

    @cached_property
    def paths(self) -> PathsAlong:
        """The paths along the bar, put in order where one is looked for."""
        return PathsAlong(self.made.paths)

    def run(self) -> tuple[Diagnostic, ...]:
        """All faults."""
        laid = self.laid = self._lay_out()
        parts = [one.part for one in laid]
        required = _Required()
        texts = self._told_texts()
        for p, one in enumerate(laid):
            self.diagnostics += left_to_manual_work(one.part, self.machine)
            if texts is not None:
                self.diagnostics += texts.check(p, one.part, one.ends, one.start)
            elif TextMark in map(type, one.part.features):
                self._find_texts(p, one, required.led)
            self._require(p, one, required)
        # A hole at the end of a slot is one of the part before it is one that a mill goes into.
        required_holes = sorted(required.holes, key=lambda hole: hole.target.optional)
        unmade = self.holes.take(required_holes)
        left = self._missed(unmade, required.optional)
        self.diagnostics += self.holes.complain(left, parts)
        needed = {(w.part, w.target.feature) for w in left}
        gone = {(w.part, w.target.feature) for w in unmade if not w.target.optional}
        self.diagnostics += self._left_out(parts, required.missing | (gone - needed))
        done = [Done(w.part, self.holes.bores[i]) for i, w in self.holes.made.items()]
        shapes = [(w.part, shape_of(w.target)) for w in self.holes.made.values()]
        if self.made.paths or required.led:
            paths = check_paths(
                self.made.paths, required.led, parts, self.tools, self.profile, self.name
            )
            self.diagnostics += paths.diagnostics
            done += (Done(led.part, path) for path, led in paths.taken)
            milled = [(p, w.target) for p, w in paths.taken if isinstance(w.target, RequiredPocket)]
            self.diagnostics += entry_faults(self.made, milled, self.tools, self.name)
            shapes += ((led.part, shape_of(led.target)) for _, led in paths.taken)
        for p, one in enumerate(laid):
            own = {s.feature: s for q, s in shapes if q == p and s is not None}
            self.diagnostics += steel_faults(tuple(own.values()), one.part, one.ends, self.machine)
        if texts is not None:
            done += (Done(part, text) for part, text in texts.taken)
        self.diagnostics += parting_faults(
            self.made, laid, done, self.cuts, self.machine, self.profile, self.name
        )
        if texts is not None:
            self.diagnostics += texts.extra()
        return tuple(self.diagnostics)

    def _require(self, p: int, one: LaidPart, required: "_Required") -> None:
        """Add what a part on the bar requires; what the machine cannot make is reported."""
        targets = self._targets_of(one.part, one.ends)
        may_lack: Collection[int] = ()
        if self.asked.skips:
            may_lack = may_be_missing(one.part, targets, self.tools, self.asked.skips)
        required.optional |= {(p, f) for f in may_lack}
        holes, from_x = required.holes, self.tools.drill.x + one.start
        gone: set[int] = set()  #: slots that are left out, with the holes at their ends
        for target in targets:
            if isinstance(target, RequiredRound):
                if not (target.optional and target.feature in gone):
                    holes.append(RequiredHole(p, target, from_x + target.x))
            elif isinstance(target, Unmakeable):
                if target.feature in may_lack:
                    required.missing.add((p, target.feature))
                else:
                    self.diagnostics.append(_unmakeable(target, one.part))
            elif target.feature in may_lack and not is_led(self.paths, target, from_x, self.tools):
                gone.add(target.feature)
                required.missing.add((p, target.feature))
            else:
                required.led.append(RequiredPath(p, target, from_x))

    def _told_texts(self) -> "PrintedTexts | None":
        """What a stamp or printer is told; None where strokes letter."""
        if not self.machine.marks.is_told:
            return None
        from beamcam.checks.bars.texts import PrintedTexts

        return PrintedTexts(self.made.texts, self.tools, self.name)

    def _find_texts(self, p: int, one: LaidPart, led: list[RequiredPath]) -> None:
        """Add the strokes of a part's texts, and what is wrong with their places."""
        from beamcam.checks.bars.texts import texts_of

        from_x = self.tools.drill.x + one.start
        marking_paths, diagnostics = texts_of(
            one.part, one.ends, self.made.paths, from_x, self.tools
        )
        led += (RequiredPath(p, target, from_x) for target in marking_paths)
        self.diagnostics += diagnostics

    def _targets_of(self, part: Part, ends: tuple[RequiredEnd, RequiredEnd]) -> list[Target]:
        known = self.targets.get(id(part))
        if known is None:
            known = self.targets[id(part)] = targets_of(part, ends, self.tools)
        return known

    def _lay_out(self) -> list[LaidPart]:
        """The parts on the bar; faults of its cuts are reported."""
        if self.machine.saw is None:
            return self._come_cut()
        job, saw = self.asked, self.saw
        cuts = self.cuts
        found = pieces(cuts, job.bar)
        laid = lay_out(found, job.parts, self.machine, saw, job.free, job.turn, self._faults)
        if len(laid) == len(job.parts):
            used = wedge_cuts(laid, cuts, self.machine, saw, job.bar)
            for one in laid:
                if one.piece is not None and used is not None:
                    used |= {one.piece.start.cut.line, one.piece.end.cut.line}
            whole = used is not None and len(used - {0}) == len(self.made.cuts)
            if whole and not overlapping(cuts):
                return laid
        return self._complain_of_cuts(laid)

    def _come_cut(self) -> list[LaidPart]:
        """The parts on a line without a saw: the only one begins where the bar does."""
        job = self.asked
        for cut in self.made.cuts:
            source = Source(self.name, cut.line)
            self.diagnostics.append(
                rules.CUT_EXTRA.at(source, angle=f"{cut.angle:g}", x=f"{cut.x:g}")
            )
        for part in job.parts[1:]:
            self.diagnostics.append(rules.ONE_PART.at(part.source, mark=part.mark))
        first = job.parts[0]
        ways = [part for part in orientations(first) if part.profile == self.profile]
        meant = [Candidate(p, 0, ends_of(p, self.saw)) for p in (ways if job.turn else [first])]
        best = min(meant, key=lambda candidate: self._faults(candidate, 0.0))
        return [LaidPart(best.part, 0, best.ends, 0.0, None)]

    def _complain_of_cuts(self, laid: Sequence[LaidPart]) -> list[LaidPart]:
        """The parts placed by the nearest cuts; faults of the cuts are reported."""
        job = self.asked
        parts: list[Part] = list(job.parts)
        if job.free or job.turn:  # those that are found stay as they lie
            missing = {*range(len(parts))} - {one.given for one in laid}
            parts = [*(one.part for one in laid), *(parts[i] for i in sorted(missing))]
        ends = [ends_of(part, self.saw) for part in parts]
        faults = CutFaults(self.made.cuts, self.machine, self.saw, self.name)
        faults.place(parts, ends)
        last = parts[-1]
        x = self.saw.x + faults.starts[-1] + last.length + ends[-1][1].kerf(self.saw) / 2
        angle = f"{self.saw.zero_angle:g}"
        # Behind a skew end at the end of the bar alone no cut is needed, and there it is not.
        self.diagnostics += faults.diagnostics or [
            rules.CUT_MISSING.at(last.source, angle=angle, x=f"{x:.6g}", end="end", mark=last.mark)
        ]
        return [
            LaidPart(part, i, ends[i], start, None)
            for i, (part, start) in enumerate(zip(parts, faults.starts, strict=True))
        ]

    def _faults(self, candidate: Candidate, start: float) -> tuple[int, int]:
        """Number of missing features of a part if it starts at a bar x.

        Of two ways with as many the one is meant in which more is made.
        """
        from_x = self.tools.drill.x + start
        part, tools = candidate.part, self.tools
        targets = self._targets_of(part, candidate.ends)
        may_lack = may_be_missing(part, targets, tools, self.asked.skips)
        missing = [
            t.feature
            for t in targets
            if isinstance(t, Unmakeable)
            or (
                not self.holes.is_made(RequiredHole(0, t, from_x + t.x))
                if isinstance(t, RequiredRound)
                else not is_led(self.paths, t, from_x, tools)
            )
            if not (isinstance(t, RequiredRound) and t.optional)
        ]
        return sum(f not in may_lack for f in missing), len(missing)

    def _missed(
        self, left: Sequence[RequiredHole], optional: Collection[tuple[int, int]]
    ) -> list[RequiredHole]:
        """The required holes that nothing makes.

        A feature that may be missing is there wholly, or nothing of it is.
        """
        made = {
            (w.part, w.target.feature) for w in self.holes.made.values() if not w.target.optional
        }
        return [
            w for w in left if (key := (w.part, w.target.feature)) not in optional or key in made
        ]

    def _left_out(
        self, parts: Sequence[Part], missing: Collection[tuple[int, int]]
    ) -> Iterator[Diagnostic]:
        """Remarks on features that are missing as allowed, whether written once or twice."""
        for p in sorted({p for p, _ in missing}):
            features = {f for q, f in missing if q == p}
            yield from left_out(parts[p], {*features, *repeats(features, parts[p], self.tools)})


def _section(
    made: MachinedFeatures, profile: Profile, machine: Machine, name: str
) -> Iterator[Diagnostic]:
    """The program's data of the bar, compared with the parts' profile."""
    expected = {
        "height": profile.height,
        "width": profile.width,
        "section": float(machine.sections.get(profile.code, -1)),
    }
    for what, value in made.section:
        if not isnan(value) and abs(value - expected[what]) > 0.75 * machine.format.resolution:
            yield rules.SECTION.at(
                Source(name), what=what, found=f"{value:g}", expected=f"{expected[what]:g}"
            )


def _unmakeable(unmakeable: Unmakeable, part: Part) -> Diagnostic:
    if unmakeable.place is None:
        return rules.NOT_MADE.at(unmakeable.source.source, found=unmakeable.what, mark=part.mark)
    x, y = unmakeable.place
    face = getattr(unmakeable.source, "face", "")
    return rules.OUTLINE.at(
        unmakeable.source.source, face=face, mark=part.mark, x=f"{x:g}", y=f"{y:g}"
    )
