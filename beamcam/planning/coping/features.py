"""The features of a part by what becomes of them: cut, on the list of manual work, left out."""

from collections.abc import Collection

from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.description import policy_on
from beamcam.model.part import Contour, Feature, Hole, Part, Profile, Slot
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.left_out import listed_by, refuse_mark


class Sorted(Struct, frozen=True):
    """Features by their indices in the part."""

    cut: tuple[int, ...]
    listed: dict[int, str]  #: why they are manual work
    skipped: dict[int, Diagnostic]  #: why they are left out, which is allowed
    refusals: tuple[Diagnostic, ...]


def sorted_features(part: Part, machine: Machine, coper: Coper, skips: Collection[str]) -> Sorted:
    """What becomes of each feature; `skips` are the kinds that may be left out."""
    cut: list[int] = []
    listed: dict[int, str] = {}
    skipped: dict[int, Diagnostic] = {}
    refusals: list[Diagnostic] = []
    for f, feature in enumerate(part.features):
        said: Diagnostic | None
        if policy_on(feature, machine.marks) is not None:
            why = listed_by(feature, machine.marks)
            said = refuse_mark(feature, machine.marks) or _unmarked(feature)
            if why is not None:
                listed[f] = why
                continue
        else:
            said = _refusal(feature, part.profile, coper)
            if said is None:
                cut.append(f)
                continue
        if said.code.removeprefix("plan-") in skips:
            skipped[f] = said
        else:
            refusals.append(said)
    return Sorted(tuple(cut), listed, skipped, tuple(refusals))


def _unmarked(mark: Feature) -> Diagnostic:
    """The refusal of a mark that the machine file wants made, as no coper marks."""
    return bar_rules.MARK.at(
        mark.source, found="a mark", face=getattr(mark, "face", ""), why=bar_rules.no_unit("tool")
    )


def _refusal(feature: Feature, profile: Profile, coper: Coper) -> Diagnostic | None:
    """Why a torch cannot make a feature wherever it is on its wall; None if it can."""
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
