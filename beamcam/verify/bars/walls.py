"""Where the walls of a section lie, measured across it; the read-back's own table.

Across the web z counts from the h side (0) to the v side (the section's width), as DSTV's section
axes have it. What stands here is written from the drawings of the sections and not taken from
`model`, so that a fault there cannot be on both sides of the comparison.

    code    wall behind v, h            z from            to
    I       web, in the middle          (width - t) / 2   (width + t) / 2
    U, C    web, on the h side          0                 t
    L       leg, on the h side          0                 t
    T       stem, on the h side         0                 t
    M       two walls, v has its own    width - t         width
    B       the plate itself
"""

from beamcam.model.part import Face, Profile


def wall_thickness(profile: Profile, face: Face) -> float:
    """Thickness of the wall behind a face, mm; 0 where it is not known."""
    if face in ("o", "u") and profile.code != "B":
        return profile.flange_thickness
    return profile.web_thickness or 0.0


def recess(profile: Profile, face: Face) -> float:
    """How far a face lies behind the outermost steel on its side, mm."""
    width, wall = profile.width, profile.web_thickness or 0.0
    match profile.code, face:
        case "I", "v" | "h":
            return width - (width + wall) / 2
        case "U" | "C" | "L" | "T", "v":
            return width - wall
        case _:
            return 0.0
