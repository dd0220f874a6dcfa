"""What a coper's program says of its part by itself: the head's words, and the strokes."""

import re

from beamcam.checks.coping.chart import job_of
from beamcam.checks.coping.profile_torch import ProfileTorch, TurnedTorch
from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.strokes import TorchFollower, TorchStroke
from beamcam.checks.coping.tube import TubeTorch, tube_section
from beamcam.checks.job import Head
from beamcam.controllers import cell_events
from beamcam.controllers.events import in_degrees
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part, Profile
from beamcam.model.rounds import rolled
from beamcam.model.section import measures_of

#: A round tube, which its diameter and its wall say, in the catalogue or not.
_TUBE = re.compile(
    r"(?:PIPE|CHS|TUBE)\s*([0-9]+(?:\.[0-9]+)?)[*X]([0-9]+(?:\.[0-9]+)?)", re.IGNORECASE
)
_NAMED = re.compile(r"(?:MARK (.*?))?(?: ?\bDRAWING (.*?))?(?: ?\bORDER (.*))?")


def head_profile(head: Head | None) -> Profile | None:
    """The section that a head names: one of the catalogue, or a round tube by its figures."""
    name = head.stock.replace("_", "*") if head is not None else ""  # as comments have it
    known = measures_of(name)
    if known is not None:
        return Profile(known[0], name, *known[1])
    tube = _TUBE.fullmatch(name)
    if tube is None:
        return None
    across, wall = float(tube[1]), float(tube[2])
    return Profile("RO", name, across, across, wall, wall) if 0 < 2 * wall < across else None


def head_part(head: Head | None, profile: Profile, name: str) -> Part:
    """A part of a section with the length, the grade and the names that a head has; no features."""
    if head is None or not head.parts:
        return Part("", profile, 0.0, Source(name), grade=head.grade if head else "")
    part = head.parts[0]
    match = _NAMED.fullmatch(part.texts)
    mark, drawing, order = (text or "" for text in match.groups()) if match else ("", "", "")
    return Part(
        mark, profile, part.size[0] if part.size else 0.0, Source(name),
        order=order, drawing=drawing, grade=head.grade,
    )  # fmt: skip


def strokes_of(
    text: str, part: Part, machine: Machine, name: str
) -> tuple[list[TorchStroke], list[Diagnostic]]:
    """What the torch cuts of a part's section, in its order, and what is wrong by itself.

    Raises TypeError for a machine without a coper.
    """
    job = job_of(part, machine, name)
    events, diagnostics = cell_events(text, machine, name)
    if errors_in(diagnostics):
        return [], list(diagnostics)
    torch: TorchFollower
    if job.coper.unrolls(part.profile.code):
        section = tube_section(rolled(part), job.coper)
        events = in_degrees(events, job.coper, 2 * section.half_y)
        torch = TubeTorch(job, section)
    else:
        follower = TurnedTorch if job.coper.turns == "bar" else ProfileTorch
        torch = follower(job, CoperSection(part.profile))
    torch.follow(events)
    return torch.strokes, [*diagnostics, *torch.diagnostics]
