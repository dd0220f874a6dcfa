"""Name of a section, and whether its label agrees with its dimensions."""

from beamcam.errors import Diagnostic, Source
from beamcam.model import catalogue
from beamcam.model.part import Profile
from beamcam.readers.ifc import rules


def named(profile: Profile, label: str) -> tuple[str, str | None]:
    """The name of a section, and the file's label where the dimensions contradict it.

    The label stands unless the catalogue knows it by other measures; a section without one has
    the catalogue's name, or one made of its measures.
    """
    if not label:
        return name_of(profile), None
    known = catalogue.measures_of(label)
    # Measures of angles and tubes do not say which side is up.
    if known is None or (
        known[0] == profile.code and catalogue.difference(profile, known[1]) <= 1.0
    ):
        return label, None
    return name_of(profile), label


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
