"""What becomes of each feature of a part: it is cut, left for manual work, left out, or refused."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndPlane, Face, Feature, Hole, Part, Profile, Slot
from beamcam.model.plan import CopeCut, CopePlan, Outcome, Piece
from beamcam.model.request import policy_on
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.coping.stock import length_needed, stock_notes
from beamcam.planning.left_out import listed_by, refuse_mark
from beamcam.planning.within import overlapping, within_larger

LEAST_SLANT = 0.5  #: mm that a square cut is off inside of a wall, and that are manual work


class FeatureLedger(Struct, frozen=True):
    """Features by their indices in the part."""

    cut: tuple[int, ...]
    listed: dict[int, str]  #: why they are manual work
    skipped: dict[int, Diagnostic]  #: why they are left out, which is allowed
    refusals: tuple[Diagnostic, ...]
    within: dict[int, Diagnostic]  #: in larger openings
    notes: tuple[Diagnostic, ...]  #: of openings in and over others


def sorted_features(
    part: Part, machine: Machine, coper: Coper, skips: Collection[str],
    idle: Mapping[int, Diagnostic] = {},
) -> FeatureLedger:  # fmt: skip
    """What becomes of each feature; `skips` may be left out, `idle` planes take nothing."""
    cut: list[int] = []
    listed: dict[int, str] = {}
    skipped: dict[int, Diagnostic] = {}
    refusals: list[Diagnostic] = []
    within = within_larger(part)
    for f, feature in enumerate(part.features):
        diagnostic: Diagnostic | None
        if f in within or f in idle:
            continue
        if policy_on(feature, machine.marks) is not None:
            why = listed_by(feature, machine.marks)
            # No coper marks what the machine file wants made.
            diagnostic = refuse_mark(feature, machine.marks) or bar_rules.MARK.at(
                feature.source, found="a mark", face=getattr(feature, "face", ""),
                why=bar_rules.no_unit("tool"),
            )  # fmt: skip
            if why is not None:
                listed[f] = why
                continue
        else:
            diagnostic = _refusal(feature, part.profile, coper)
            if diagnostic is None:
                cut.append(f)
                continue
        if diagnostic.code.removeprefix("plan-") in skips:
            skipped[f] = diagnostic
        else:
            refusals.append(diagnostic)
    notes = (*idle.values(), *within.values(), *overlapping(part, within))
    return FeatureLedger(tuple(cut), listed, skipped, tuple(refusals), within, notes)


def _refusal(feature: Feature, profile: Profile, coper: Coper) -> Diagnostic | None:
    """Why a torch cannot make a feature wherever it is on its wall; None if it can."""
    if isinstance(feature, EndPlane) and coper.unrolls(profile.code) and feature.normal[0]:
        return None
    if not isinstance(feature, Hole | Slot | Contour):
        what = type(feature).__name__.lower()
        return bar_rules.OTHER.at(feature.source, found=f"a feature of kind {what}")
    faces = {"L": "vhu", "T": "vu", "RO": "v"}.get(profile.code, "vhou")
    kind = type(feature).__name__.lower()
    if feature.face not in faces:
        expected = f"a face that the torch looks at: {', '.join(faces)}"
        return bar_rules.NO_SPINDLE.at(
            feature.source, kind=kind, found=feature.face, expected=expected
        )
    wall = profile.thickness(feature.face) or profile.flange_thickness
    least = max(coper.min_hole, coper.min_hole_share * wall)
    if isinstance(feature, Contour):
        if feature.process != "cut" or feature.kind == "open" or not feature.closed:
            return bar_rules.OTHER.at(feature.source, found="an open line to cut")
        boxes = [curve.bbox for curve in feature.curves]
        x, y = min(b[0] for b in boxes), min(b[1] for b in boxes)
        size = min(max(b[2] for b in boxes) - x, max(b[3] for b in boxes) - y)
        if feature.kind == "inner" and size < least:
            return rules.NARROW.at(
                feature.source, what=f"a cut-out of {size:g} mm", x=f"{x:g}", y=f"{y:g}",
                face=feature.face, expected=f"one of at least {least:g} mm",
            )  # fmt: skip
        return None
    expected = f"a through one of at least {least:g} mm, which the torch burns"
    if feature.kind != "through" or feature.depth is not None or feature.diameter < least:
        if isinstance(feature, Slot):
            return bar_rules.SLOT.at(
                feature.source, found=f"{feature.diameter:g}", face=feature.face, expected=expected
            )
        return bar_rules.NO_TOOL.at(
            feature.source, kind=feature.kind, found=f"{feature.diameter:g}", face=feature.face,
            expected=expected,
        )  # fmt: skip
    return None


def plan_of(
    part: Part, given: Part, machine: Machine, ledger: FeatureLedger, cuts: Sequence[CopeCut],
    diagnostics: Sequence[Diagnostic], left: Callable[[int, Feature], str],
) -> CopePlan:  # fmt: skip
    """The plan of some cuts, with the outcome of each feature; `left` says why one that is cut is
    manual work too. Raises PlanError without any cut."""
    coper = machine.needed(machine.coper, "coper")
    if not cuts:
        raise PlanError(bar_rules.NO_WORK.at(part.source, machine=machine.name))
    outcomes = []
    for k, feature in enumerate(part.features):
        if k in ledger.listed:
            outcomes.append(Outcome((0, k), "listed", ledger.listed[k]))
        elif k in ledger.skipped:
            outcomes.append(Outcome((0, k), "skipped", ledger.skipped[k].code))
        elif k in ledger.within:
            outcomes.append(Outcome((0, k), "duplicate", ledger.within[k].code))
        else:
            outcomes.append(Outcome((0, k), "made", "cut", left(k, feature)))
    return CopePlan(
        part.profile, (Piece(given, coper.trim),), length_needed(part, coper), tuple(cuts),
        tuple(outcomes), (*diagnostics, *stock_notes(part, given, coper), *ledger.notes),
        min_bevel=coper.min_bevel,
    )  # fmt: skip


def has_bevels(feature: Feature, least: float) -> bool:
    """Whether edges of a contour are bevelled by so many degrees."""
    return isinstance(feature, Contour) and any(abs(b.angle) >= least for b in feature.bevels)


def slant_notes(part: Part, slant: Mapping[Face, float]) -> Iterator[Diagnostic]:
    """A warning of the walls that a square cut leaves skew, by how many mm."""
    if slant:
        yield rules.SLANT.at(
            part.source, found=f"{max(slant.values()):.2f}", faces=", ".join(slant)
        )
