"""Programs of copers read back and compared with the part that they should make.

    text -> events (controllers) -> strokes of the torch, square to a wall -> pieces of the walls

Written from the controller's documentation, the machine file and the figures of the section;
nothing is shared with planning and motion, nor is the map of surfaces that they go by.
"""

from collections.abc import Collection, Sequence

from msgspec.structs import replace

from beamcam.checks.job import left_out, left_to_manual_work, manual_work
from beamcam.controllers import cell_events
from beamcam.controllers.events import BarEvent, in_degrees
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.coper import TUBES, Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow, is_row_for, material_said
from beamcam.model.part import Part


def verify_coping(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """All faults of a program, by itself and against the part that it makes.

    `skips` are the kinds of features that may be missing, as `--allow-skips` names them. Without a
    part only its blocks are read. Raises TypeError for a machine without a coper.
    """
    from beamcam.checks.coping import rules
    from beamcam.checks.coping.lying import lying
    from beamcam.checks.coping.tube import tube_faults, tube_section
    from beamcam.checks.coping.wanted import may_be_left
    from beamcam.model.rounds import rolled

    coper = machine.needed(machine.coper, "coper")
    events, diagnostics = cell_events(text, machine, name)
    if errors_in(diagnostics) or not parts:
        return tuple(diagnostics)
    if len(parts) > 1:
        return (*diagnostics, rules.PARTS.at(Source(name), found=len(parts)))
    part = rolled(parts[0]) if coper.turns == "bar" else parts[0]
    code, codes = part.profile.code, codes_read(coper)
    if code not in codes:
        expected = ", ".join(codes)
        return (*diagnostics, rules.SECTION.at(Source(name), found=code, expected=expected))
    if code == "M":
        size, wall = part.profile, tube_section(part, coper)
        most = min(size.height, size.width) / 2
        if not wall.wall <= wall.radius <= most:
            return (*diagnostics, rules.RADIUS.at(
                part.source, found=f"{wall.radius:g}", name=size.name or "a tube",
                least=f"{wall.wall:g}", most=f"{most:g}",
            ))  # fmt: skip
    if code == "C":
        lip = part.profile.lip if part.profile.lip is not None else coper.lip
        least, most = (part.profile.web_thickness or 0.0) + part.profile.radius, part.profile.height
        if not least <= lip < most / 2:
            return (*diagnostics, rules.LIP.at(
                part.source, found=f"{lip:g}", name=part.profile.name or "a C",
                least=f"{least:g}", most=f"{most / 2:g}",
            ))  # fmt: skip
        part = replace(part, profile=replace(part.profile, lip=lip))
    part = lying(part)
    material = material_said(part.grade, coper.material)
    rows = [row for row in coper.rows if is_row_for(row.material, material)]
    left = may_be_left(part, machine, coper, skips)
    if coper.unrolls(part.profile.code):
        events = in_degrees(events, coper, part.profile.height)
        diagnostics += tube_faults(events, part, machine, coper, rows, left, name)
    else:
        diagnostics += _profile_faults(events, part, machine, coper, rows, left, name)
    if errors_in(diagnostics):
        return tuple(diagnostics)
    return (*diagnostics, *left_to_manual_work(part, machine), *left_out(part, left))


def codes_read(coper: Coper) -> tuple[str, ...]:
    """DSTV codes of the sections whose programs are read back."""
    if coper.a_unit == "mm":
        return ("RO",)
    return ("I", "U", "L", "T", "C", *(TUBES if coper.turns == "bar" else ()))


def _profile_faults(
    events: Sequence[BarEvent], part: Part, machine: Machine, coper: Coper,
    rows: Sequence[TorchRow], left: Collection[int], name: str,
) -> list[Diagnostic]:  # fmt: skip
    """What is wrong with a torch that goes round a profile, or over one that turns, and what it
    leaves for manual work."""
    from beamcam.checks.coping.collisions import collision_faults, turned_unseen
    from beamcam.checks.coping.compare import compare
    from beamcam.checks.coping.profile_torch import ProfileTorch
    from beamcam.checks.coping.required import is_outline_of, walls_asked
    from beamcam.checks.coping.section import CoperSection
    from beamcam.checks.coping.skew import plane_faults, skew_ends
    from beamcam.checks.coping.stock import stock_of
    from beamcam.checks.coping.turned import TurnedTorch
    from beamcam.checks.coping.zones import chuck_faults, root_faults, support_faults

    section = CoperSection(part.profile)
    does_turn = coper.turns == "bar"
    torch = (TurnedTorch if does_turn else ProfileTorch)(machine, coper, section, rows, name)
    torch.follow(events)
    diagnostics = [*torch.diagnostics, *collision_faults(torch.ways, section, coper, name)]
    if does_turn:
        diagnostics += turned_unseen(events, section, coper, name)
        diagnostics += chuck_faults(torch.ways, part, coper, name)
    if errors_in(diagnostics):
        return diagnostics
    diagnostics += plane_faults(part, section, skew_ends(part, section), left)
    stock = stock_of(part, section, coper)
    asked = walls_asked(part, section, coper, rows, left, stock, torch.strokes)
    diagnostics += compare(
        torch.strokes, asked.wanted, asked.ends, asked.made, asked.passes, stock, section, coper,
        rows, machine.format.resolution, name,
    )  # fmt: skip
    diagnostics += root_faults(torch.strokes, section, coper, name)
    diagnostics += support_faults(torch.strokes, coper, name)
    hand = (
        manual_work(f, part, machine) for k, f in enumerate(part.features)
        if k not in left and (is_outline_of(f, asked.off) or asked.has_bevels_left(k, f, coper))
    )  # fmt: skip
    return [*diagnostics, *hand]
