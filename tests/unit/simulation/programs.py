"""Programs run on the model of a cell."""

from beamcam.checks.bars import run
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.simulation.cell_trace import MotionSegment, motion_segments


def course_of(
    text: str, machine: Machine, profile: Profile | None = None
) -> tuple[MotionSegment, ...]:
    """What the axes do over time while a program runs."""
    done = run(text, machine, profile)
    return motion_segments(done.events, done.dialect, dict(done.made.section), machine)
