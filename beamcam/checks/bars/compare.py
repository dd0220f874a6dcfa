"""Check that each required feature is machined exactly once, in its place, and no other.

cuts -> pieces of bar -> parts;  holes, pockets and lines of each part -> what made them
"""

from collections.abc import Collection, Iterable, Sequence
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING

from msgspec import Struct

from beamcam.checks import rules
from beamcam.checks.bars.ability import FeatureRef, may_be_missing, repeats
from beamcam.checks.bars.cuts import CutFaults
from beamcam.checks.bars.holes import HoleCheck, RequiredHole
from beamcam.checks.bars.machine_limits import (
    CornerCircles,
    reach_faults,
    section_faults,
    shape_of,
    steel_faults,
)
from beamcam.checks.bars.orientations import orientations
from beamcam.checks.bars.paths import PathsAlong, RequiredPath, check_paths, is_followed
from beamcam.checks.bars.pieces import (
    LaidPart,
    ends_of,
    lay_out,
    overlapping,
    pieces,
    planes,
    wedge_cuts,
)
from beamcam.checks.bars.stations import Choice, MachinedFeatures
from beamcam.checks.bars.targets import RequiredRound, Target, Unmakeable, targets_of
from beamcam.checks.bars.tools import ToolCatalogue, Work, parting_faults
from beamcam.checks.job import left_out, left_to_manual_work
from beamcam.errors import Diagnostic, Rule, Source
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


class Comparison:
    """Comparison of one program with the required parts; `diagnostics` holds its faults."""

    def __init__(
        self, made: MachinedFeatures, required: RequiredParts, tools: ToolCatalogue,
        profile: Profile, choices: dict[int, Choice], name: str,
    ) -> None:  # fmt: skip
        self.made, self.required, self.tools = made, required, tools
        self.machine: Machine = tools.machine
        self.saw, self.profile, self.name = saw_of(tools.machine), profile, name
        self.targets: dict[int, list[Target]] = {}
        self.holes = HoleCheck(made.bores, tools, profile, choices, name)
        self.cuts = planes(made.cuts, self.saw, profile)
        self.laid: list[LaidPart] = []  #: the parts, once they are known
        #: What the parts on the bar require; features are a part and its feature, by their indices.
        self.required_holes: list[RequiredHole] = []
        self.required_paths: list[RequiredPath] = []
        self.optional: set[FeatureRef] = set()  #: that may be missing
        self.missing: set[FeatureRef] = set()  #: those that are
        self.diagnostics: list[Diagnostic] = []

    def say(self, rule: Rule, source: Source, **values: object) -> None:
        self.diagnostics.append(rule.at(source, **values))

    @cached_property
    def paths(self) -> PathsAlong:
        """The paths along the bar, put in order where one is searched."""
        return PathsAlong(self.made.paths)

    def run(self) -> tuple[Diagnostic, ...]:
        """All faults."""
        made, machine, name = self.made, self.machine, self.name
        self._check_section()
        self.diagnostics += section_faults(self.profile, machine, name)
        self.diagnostics += reach_faults(made.cuts, self.profile, machine, name)
        laid = self.laid = self._lay_out()
        parts = [one.part for one in laid]
        texts: PrintedTexts | None = None
        if machine.marks.is_told:  # by a stamp or printer; else strokes letter
            from beamcam.checks.bars import texts as lettering

            texts = lettering.PrintedTexts(made.texts, self.tools, name)
        for p, one in enumerate(laid):
            self.diagnostics += left_to_manual_work(one.part, machine)
            if texts is not None:
                self.diagnostics += texts.check(p, one.part, one.ends, one.start)
            elif TextMark in map(type, one.part.features):
                from beamcam.checks.bars.texts import texts_of

                from_x = self.tools.drill.x + one.start
                strokes, diagnostics = texts_of(one.part, one.ends, made.paths, from_x, self.tools)
                self.required_paths += (RequiredPath(p, target, from_x) for target in strokes)
                self.diagnostics += diagnostics
            self._require(p, one)
        self._check_holes(parts)
        met: list[RequiredHole | RequiredPath] = [*self.holes.made.values()]
        done: list[tuple[int, Work]] = [
            (required.part, made.bores[i]) for i, required in self.holes.made.items()
        ]
        if made.paths or self.required_paths:
            diagnostics, taken = check_paths(
                made, self.required_paths, parts, self.tools, self.profile, name
            )
            self.diagnostics += diagnostics
            for path, required in taken:
                met.append(required)
                done.append((required.part, path))
        self._check_steel(met)
        if texts is not None:
            done += texts.taken
        self.diagnostics += parting_faults(made, laid, done, self.cuts, machine, self.profile, name)
        if texts is not None:
            self.diagnostics += texts.extra()
        return tuple(self.diagnostics)

    def _check_section(self) -> None:
        """The program's data of the bar, compared with the parts' profile."""
        profile = self.profile
        expected = {
            "height": profile.height, "width": profile.width,
            "section": float(self.machine.sections.get(profile.code, -1)),
        }  # fmt: skip
        for what, value in self.made.section:
            # A value that is not known is off by nothing that can be compared.
            if abs(value - expected[what]) > 0.75 * self.machine.format.resolution:
                found, shown = f"{value:g}", f"{expected[what]:g}"
                self.say(rules.SECTION, Source(self.name), what=what, found=found, expected=shown)

    def _check_holes(self, parts: Sequence[Part]) -> None:
        """Find the bores that make the holes; faults are reported."""
        holes = self.holes
        # A hole at the end of a slot is one of the part before it is one that a mill goes into.
        unmade = holes.take(sorted(self.required_holes, key=attrgetter("target.optional")))
        left = unmade
        if self.optional:  # a feature that may be missing is there wholly, or nothing of it is
            begun = {_feature(w) for w in holes.made.values() if not w.target.optional}
            left = [w for w in unmade if _feature(w) not in self.optional or _feature(w) in begun]
            gone = {_feature(w) for w in unmade if not w.target.optional}
            self.missing |= gone - {_feature(w) for w in left}
        self.diagnostics += holes.complain(left, parts)
        for p in sorted({p for p, _ in self.missing}):
            features = {f for q, f in self.missing if q == p}
            twice = repeats(features, parts[p], self.tools)
            self.diagnostics += left_out(parts[p], {*features, *twice})

    def _check_steel(self, met: Iterable[RequiredHole | RequiredPath]) -> None:
        """Report what of the holes and slots that are made has no steel all round."""
        shapes: list[dict[int, CornerCircles]] = [{} for _ in self.laid]  #: of a part, by feature
        for required in met:
            if (shape := shape_of(required.target)) is not None:
                shapes[required.part][shape.feature] = shape
        for own, one in zip(shapes, self.laid, strict=True):
            self.diagnostics += steel_faults(own.values(), one.part, one.ends, self.machine)

    def _require(self, p: int, one: LaidPart) -> None:
        """Add what a part on the bar requires; what the machine cannot make is reported."""
        targets, skips, part = self._targets_of(one), self.required.skips, one.part
        may_miss: Collection[int] = ()
        if skips:
            may_miss = may_be_missing(part, targets, self.tools, skips)
        self.optional |= {(p, f) for f in may_miss}
        from_x = self.tools.drill.x + one.start
        gone: set[int] = set()  #: slots that are left out, with the holes at their ends
        for target in targets:
            if isinstance(target, RequiredRound):
                if not (target.optional and target.feature in gone):
                    self.required_holes.append(RequiredHole(p, target, from_x + target.x))
            elif isinstance(target, Unmakeable):
                source = target.source.source
                if target.feature in may_miss:
                    self.missing.add((p, target.feature))
                elif target.place is None:
                    self.say(rules.NOT_MADE, source, found=target.what, mark=part.mark)
                else:
                    x, y = (f"{place:g}" for place in target.place)
                    face = getattr(target.source, "face", "")
                    self.say(rules.OUTLINE, source, face=face, mark=part.mark, x=x, y=y)
            elif target.feature in may_miss and not is_followed(
                self.paths, target, from_x, self.tools
            ):
                gone.add(target.feature)
                self.missing.add((p, target.feature))
            else:
                self.required_paths.append(RequiredPath(p, target, from_x))

    def _targets_of(self, one: LaidPart) -> list[Target]:
        known = self.targets.get(id(one.part))
        if known is None:
            known = self.targets[id(one.part)] = targets_of(one.part, one.ends, self.tools)
        return known

    def _lay_out(self) -> list[LaidPart]:
        """The parts on the bar; faults of its cuts are reported."""
        if self.machine.saw is None:
            return self._come_cut()
        job, saw, cuts = self.required, self.saw, self.cuts
        laid = lay_out(
            pieces(cuts, job.bar), job.parts, self.machine, saw, job.free, job.turn, self._faults
        )
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
        job = self.required
        for cut in self.made.cuts:
            source, angle = Source(self.name, cut.line), f"{cut.angle:g}"
            self.say(rules.CUT_EXTRA, source, angle=angle, x=f"{cut.x:g}")
        first, *others = job.parts
        for part in others:
            self.say(rules.ONE_PART, part.source, mark=part.mark)
        ways = [first]
        if job.turn:
            ways = [part for part in orientations(first) if part.profile == self.profile]
        meant = [LaidPart(part, 0, ends_of(part, self.saw), 0.0, None) for part in ways]
        return [min(meant, key=self._faults)]

    def _complain_of_cuts(self, laid: Sequence[LaidPart]) -> list[LaidPart]:
        """The parts placed by the nearest cuts; faults of the cuts are reported."""
        job = self.required
        parts: list[Part] = list(job.parts)
        if job.free or job.turn:  # those that are found stay as they lie
            missing = {*range(len(parts))} - {one.given for one in laid}
            parts = [*(one.part for one in laid), *(parts[i] for i in sorted(missing))]
        ends = [ends_of(part, self.saw) for part in parts]
        faults = CutFaults(self.made.cuts, self.machine, self.saw, self.name)
        faults.place(parts, ends)
        last = parts[-1]
        x = self.saw.x + faults.starts[-1] + last.length + ends[-1][1].kerf(self.saw) / 2
        self.diagnostics += faults.diagnostics
        if not faults.diagnostics:
            # Behind a skew end at the end of the bar alone no cut is needed, and there it is not.
            place = {"angle": f"{self.saw.zero_angle:g}", "x": f"{x:.6g}", "end": "end"}
            self.say(rules.CUT_MISSING, last.source, mark=last.mark, **place)
        return [
            LaidPart(part, i, ends[i], start, None)
            for i, (part, start) in enumerate(zip(parts, faults.starts, strict=True))
        ]

    def _faults(self, one: LaidPart) -> tuple[int, int]:
        """Number of missing features of a part if it lies so.

        Of two ways with as many the one is meant in which more is made.
        """
        from_x, tools = self.tools.drill.x + one.start, self.tools
        targets = self._targets_of(one)
        may_miss = may_be_missing(one.part, targets, tools, self.required.skips)
        missing = []
        for target in targets:
            if isinstance(target, RequiredRound):
                required = RequiredHole(0, target, from_x + target.x)
                is_made = target.optional or self.holes.right(required) is not None
            else:
                is_made = not isinstance(target, Unmakeable) and is_followed(
                    self.paths, target, from_x, tools
                )
            if not is_made:
                missing.append(target.feature)
        return sum(f not in may_miss for f in missing), len(missing)


def _feature(required: RequiredHole) -> FeatureRef:
    return required.part, required.target.feature
