"""Name of a section, and whether the labels of the file agree with its dimensions."""

import re
from collections.abc import Iterable

from beamcam.caches import cached
from beamcam.errors import Diagnostic, Source
from beamcam.model import catalogue
from beamcam.model.part import Profile
from beamcam.readers.ifc import rules

#: Names that are measures: of tubes, pipes, angles, flat and round bars, as modellers write them.
_MEASURES = re.compile(
    r"(?:RHS|SHS|CHS|QRO|RRO|MSH|VHP|K|KR|KKR|VKR|KCKR|RO|ROR|TUBE|PIPE?|O|D|Ø|RD|L|FL|FLT|FB|PL|BL)"
    r"[ .-]?(\d+(?:[.,]\d+)?(?:[xX*×/-]\d+(?:[.,]\d+)?)*)"
)
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
LARGEST_INCHES = 30.0  #: names whose numbers are all smaller may be in inches
SIZE_OFF = 1.0  #: mm that a size may differ from its name
WALL_OFF = 0.4  #: mm that a thickness may


def named(profile: Profile, labels: Iterable[str]) -> tuple[str, list[str]]:
    """The name of a section, and the labels that its dimensions contradict.

    The first label stands unless the catalogue knows it, or it says itself, by other measures; a
    section without one has the catalogue's name, or one made of its measures.
    """
    first, *others = labels
    wrong = [label for label in (first, *others) if label and _contradicts(label, profile)]
    name = first if first and first not in wrong else name_of(profile)
    return name, [*dict.fromkeys(wrong)]


def _contradicts(label: str, profile: Profile) -> bool:
    known = catalogue.measures_of(label)
    if known is not None:
        # Measures of angles and tubes do not say which side is up.
        return known[0] != profile.code or catalogue.difference(profile, known[1]) > SIZE_OFF
    said = _said_measures(label)
    walls, sizes = _own_measures(profile)
    if not walls or len(said) < 2 or max(said) < LARGEST_INCHES:
        return False
    if profile.code == "B":  # of a plate the other numbers may be those of a larger blank
        return all(abs(said_ - walls[0]) > WALL_OFF for said_ in said)
    if len(said) == 2 and len(sizes) == 2:  # K100*5 is square
        sizes = sizes if abs(sizes[0] - sizes[1]) <= SIZE_OFF else (0.0, 0.0)
        said = (said[0], *said)
    if len(said) != len(sizes) + 1:
        return False
    *outer, wall = sorted(said, reverse=True)
    off = (abs(a - b) for a, b in zip(outer, sorted(sizes, reverse=True), strict=True))
    return max(off) > SIZE_OFF or abs(wall - walls[0]) > WALL_OFF


@cached("ifc.said_measures")
def _said_measures(label: str) -> tuple[float, ...]:
    """The numbers of a name that is made of measures, in mm; none of another name."""
    found = _MEASURES.fullmatch(label.strip().upper())
    if found is None:
        return ()
    return tuple(float(n.replace(",", ".")) for n in _NUMBER.findall(found[1]))


def _own_measures(profile: Profile) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The thickness of a section that is named by its measures, and its sizes."""
    wall = profile.web_thickness or 0.0
    match profile.code:
        case "B":
            return (wall,), (profile.height,)
        case "RO":
            return (wall,), (profile.height,)
        case "M" | "L":
            return (wall,), (profile.height, profile.width)
    return (), ()


def name_of(profile: Profile) -> str:
    """The catalogue's name of a section, or one made of its measures."""
    return catalogue.name_of(profile) or measured_name(profile)


def remark_at(label: str, profile: Profile, source: Source) -> Diagnostic:
    return rules.PROFILE_NAME.at(
        source,
        found=label,
        size=f"{profile.height:.1f} x {profile.width:.1f} mm",
        expected=name_of(profile),
    )


def measured_name(profile: Profile) -> str:
    """A name made of the measures: I300x150x7.1x10.7, PL10x200."""
    h, b, t, w = (
        f"{v:.1f}".removesuffix(".0")
        for v in (
            profile.height,
            profile.width,
            profile.flange_thickness,
            profile.web_thickness or 0,
        )
    )
    match profile.code:
        case "B":
            return f"PL{w}x{h}"
        case "L":
            return f"L{h}x{b}x{w}"
        case "M":
            return f"RHS{h}x{b}x{w}"
        case "RO":
            return f"CHS{h}x{w}"
        case "RU":
            return f"RD{h}"
    return f"{profile.code}{h}x{b}x{w}x{t}"
