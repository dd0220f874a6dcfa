"""Programs run on the model of a cell."""

from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.simulate.course import CourseSection, stretches
from beamcam.verify.bars import run


def course_of(
    text: str, machine: Machine, profile: Profile | None = None
) -> tuple[CourseSection, ...]:
    """What the axes do over time while a program runs."""
    done = run(text, machine, profile)
    return stretches(done.events, done.dialect, dict(done.made.section), machine)
