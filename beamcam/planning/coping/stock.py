"""What a coper is given: parts and bars that it does not take, and what its file says of a section.

A plate that is the surface of a pipe is taken for the pipe.
"""

from collections.abc import Iterator, Sequence
from math import pi

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import TUBES, Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.rounds import SLACK, is_unrolled, named_diameters, rolled
from beamcam.model.section import section_fault
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.coping.walls import laid, web_back

ONE_SHEET = 0.05  #: mm between walls of a C, which are one sheet


def as_pipe(part: Part) -> tuple[Part, Diagnostic | None]:
    """A part as the pipe that its plate is the surface of, and what is said of it.

    Any other part comes back as it is, and so does a plate whose name has another diameter.
    """
    profile = part.profile
    if not is_unrolled(profile):
        return part, None
    diameter = profile.height / pi
    named = named_diameters(profile.name)
    values = {"found": profile.name, "height": f"{profile.height:g}"}
    if named and min(abs(one - diameter) for one in named) > SLACK:
        nearest = min(named, key=lambda one: abs(one - diameter))
        expected = f"{pi * nearest:.2f}"
        return part, rules.NO_PIPE.at(
            part.source, diameter=f"{nearest:g}", expected=expected, **values
        )
    return rolled(part), rules.PIPE.at(part.source, diameter=f"{diameter:.2f}", **values)


def with_corners(part: Part, coper: Coper) -> tuple[Part, Diagnostic | None]:
    """A rectangular tube with corners as the machine has them, if it says none; and why."""
    profile = part.profile
    wall = max(profile.flange_thickness, profile.web_thickness or 0.0)
    radius = coper.outer_radius(profile.radius, wall)
    if profile.code != "M" or radius == profile.radius:
        return part, None
    values = {"name": profile.name, "found": f"{radius:g}"}
    if coper.corner:
        diagnostic = rules.GIVEN_RADIUS.at(part.source, **values)
    else:
        share = f"{radius / wall:g} walls of {wall:g} mm"
        diagnostic = rules.TABLE_RADIUS.at(part.source, share=share, **values)
    return replace(part, profile=replace(profile, radius=radius)), diagnostic


def with_lip(part: Part, coper: Coper) -> tuple[Part, Diagnostic | None]:
    """A C with lips as long as the machine has them, if it does not say; that is told."""
    profile = part.profile
    if profile.code != "C" or profile.lip is not None or not coper.lip:
        return part, None
    diagnostic = rules.GIVEN_LIP.at(part.source, name=profile.name, found=f"{coper.lip:g}")
    return replace(part, profile=replace(profile, lip=coper.lip)), diagnostic


def length_needed(part: Part, coper: Coper) -> float:
    """How long a bar has to be for a part; a piece that comes cut is as long as it is."""
    return part.length + (0.0 if part.made is not None else 2 * coper.trim + coper.chuck)


def stock_notes(part: Part, given: Part, coper: Coper) -> Iterator[Diagnostic]:
    """What is to be known of the bar that a part is cut from, or of the piece that comes cut."""
    code, turns = given.profile.code, coper.turns == "bar"
    at = "to Y-" if turns else "at Y 0"
    figures = {"found": f"{length_needed(part, coper):g}", "trim": f"{coper.trim:g}"}
    if part.made is None:
        yield rules.BAR.at(part.source, **figures)
    else:
        lies = "" if code in ("T", "C") else f", face v up, face u {at}"
        lies = ", face u up, face v to Y+" if coper.a_unit == "mm" else lies
        lies += f", its last {coper.chuck:g} mm in the chuck" if turns else ""
        yield rules.PIECE.at(part.source, lies=lies, **figures)
    if part.quantity > 1:
        yield bar_rules.QUANTITY.at(part.source, found=part.quantity, made=1)
    if code == "T":
        yield rules.TEE.at(part.source)
    if code == "C":
        yield rules.LIPS.at(part.source, at=at)


def stock_faults(
    parts: Sequence[Part], machine: Machine, coper: Coper, bar: float | None
) -> Iterator[Diagnostic]:
    """Errors for parts, sections and bars that the machine does not take."""
    if not parts:
        yield bar_rules.NO_PARTS.at(Source(machine.name))
        return
    if len(parts) > 1:
        yield rules.ALONE.at(parts[0].source, found=len(parts), machine=machine.name)
        return
    (part,) = parts
    source = part.source
    profile = laid(part).profile
    if profile.code not in coper.profiles:
        yield bar_rules.STOCK.at(
            source, found=profile.code, machine=machine.name, expected=", ".join(coper.profiles)
        )
        return
    if profile.code == "C" and (profile.lip is None or section_fault(profile) is not None):
        least = (profile.web_thickness or 0.0) + profile.radius
        yield rules.NO_LIP.at(
            source, found="no length" if profile.lip is None else f"{profile.lip:g} mm",
            name=profile.name or "a C", least=f"{least:g}", most=f"{profile.height / 2:g}",
        )  # fmt: skip
        return
    fault = section_fault(part.profile)
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    if profile.code == "C" and abs(flange - web) > ONE_SHEET:
        fault = f"flanges of {flange:g} mm and a web of {web:g} mm in one bent sheet"
    if fault is not None:
        yield bar_rules.SECTION_SHAPE.at(source, found=fault, code=profile.code)
        return
    if profile.code == "M":
        least = max(profile.flange_thickness, profile.web_thickness or 0.0)
        most = min(profile.height, profile.width) / 2
        if not least <= profile.radius <= most:
            yield rules.NO_RADIUS.at(
                source, found=f"{profile.radius:g}", name=profile.name or "a tube",
                least=f"{least:g}", most=f"{most:g}",
            )  # fmt: skip
            return
    if profile.height > coper.max_height or profile.width > coper.max_width:
        yield bar_rules.SECTION_SIZE.at(
            source, found=f"{profile.height:g} x {profile.width:g}", station="torch",
            expected=f"{coper.max_height:g} x {coper.max_width:g}",
        )  # fmt: skip
    deep = profile.width - (profile.web_thickness or 0.0) - web_back(profile)
    if deep + coper.clearance > coper.torch_length and profile.code not in TUBES:
        expected = f"{coper.torch_length - coper.clearance:g}"
        yield rules.DEEP.at(source, found=f"{deep:g}", expected=expected)
    needed = length_needed(part, coper)
    if needed > coper.length:
        yield bar_rules.BAR_LONG.at(source, found=f"{needed:g}", expected=f"{coper.length:g}")
    if bar is not None and bar < needed:
        yield bar_rules.BAR_FULL.at(source, found=f"{needed:g}", expected=f"{bar:g}")
