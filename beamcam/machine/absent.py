"""Stations that a line has not: a saw that cuts nothing, a drill that reaches nothing.

A line without a saw takes parts that are cut; one without a drill saws them only. What the work
asks of a station holds for these too, so that nobody has to ask whether it is there, but for who
would make a cut, or lay several parts on a bar.
"""

from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill, Saw

NO_SAW = Saw(
    kerf=0.0,
    min_angle=-90.0,
    max_angle=90.0,
    max_height=MAX_COORDINATE,
    max_width=MAX_COORDINATE,
    min_tilt=-90.0,
    max_tilt=90.0,
    compound=True,
)
NO_DRILL = Drill(x=0.0, max_height=MAX_COORDINATE, max_width=MAX_COORDINATE, fits=(), cutting=())


def saw_of(machine: Machine) -> Saw:
    """The saw of a machine, or one that cuts nothing."""
    return machine.saw or NO_SAW


def drill_of(machine: Machine) -> Drill:
    """The drill of a machine, or one that reaches nothing."""
    return machine.drill or NO_DRILL


def text_x(machine: Machine) -> float:
    """Machine X of a text at bar x 0, where a stamp or printer letters."""
    return drill_of(machine).x if machine.marks.x is None else machine.marks.x
