"""Programs of copers read back and compared with the part that they should make.

    text -> events (controllers) -> strokes of the torch, square to a wall -> pieces of the walls

Written from the controller's documentation, the machine file and the figures of the section;
nothing is shared with planning and motion, nor is the map of surfaces that they go by.
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from beamcam.checks.job import left_out, left_to_manual_work, manual_work
from beamcam.controllers import cell_events
from beamcam.controllers.events import BarEvent, in_degrees
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.coper import TUBES, Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

if TYPE_CHECKING:
    from beamcam.checks.coping.chart import CoperJob


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
    from beamcam.checks.coping.chart import job_of
    from beamcam.checks.coping.lying import lying
    from beamcam.checks.coping.required_wall import may_be_left
    from beamcam.checks.coping.tube import tube_faults, tube_section
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
    job, left = job_of(part, machine, name), may_be_left(part, machine, coper, skips)
    if coper.unrolls(part.profile.code):
        events = in_degrees(events, coper, part.profile.height)
        diagnostics += tube_faults(events, job, left)
    else:
        diagnostics += _profile_faults(events, job, left)
    if errors_in(diagnostics):
        return tuple(diagnostics)
    return (*diagnostics, *left_to_manual_work(part, machine), *left_out(part, left))


def codes_read(coper: Coper) -> tuple[str, ...]:
    """DSTV codes of the sections whose programs are read back."""
    if coper.a_unit == "mm":
        return ("RO",)
    return ("I", "U", "L", "T", "C", *(TUBES if coper.turns == "bar" else ()))


def _profile_faults(
    events: Sequence[BarEvent], job: "CoperJob", left: Collection[int]
) -> list[Diagnostic]:
    """What is wrong with the program of a profile, and what it leaves for manual work."""
    from beamcam.checks.coping.collisions import collision_faults, turned_unseen
    from beamcam.checks.coping.compare import WallComparison
    from beamcam.checks.coping.profile_torch import ProfileTorch, TurnedTorch
    from beamcam.checks.coping.required import RequiredWalls
    from beamcam.checks.coping.section import CoperSection
    from beamcam.checks.coping.skew import plane_faults, skew_ends
    from beamcam.checks.coping.stock import stock_of
    from beamcam.checks.coping.zones import chuck_faults, root_faults, support_faults

    part, coper, name = job.part, job.coper, job.name
    section = CoperSection(part.profile)
    does_turn = coper.turns == "bar"
    torch = (TurnedTorch if does_turn else ProfileTorch)(job, section)
    torch.follow(events)
    diagnostics = [*torch.diagnostics, *collision_faults(torch.ways, section, coper, name)]
    if does_turn:
        diagnostics += turned_unseen(events, section, coper, name)
        diagnostics += chuck_faults(torch.ways, job)
    if errors_in(diagnostics):
        return diagnostics
    diagnostics += plane_faults(part, section, skew_ends(part, section), left)
    stock = stock_of(part, section, coper)
    required = RequiredWalls(job, section, stock, left, torch.strokes)
    diagnostics += WallComparison(torch.strokes, required, stock, section, job).faults()
    diagnostics += root_faults(torch.strokes, section, job)
    diagnostics += support_faults(torch.strokes, job)
    features = ((k, f) for k, f in enumerate(part.features) if k not in left)
    hand = (manual_work(f, part, job.machine) for k, f in features if required.is_left(k, f))
    return [*diagnostics, *hand]
