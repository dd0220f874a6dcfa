"""Rules for the result of a step or velocity table."""

from beamcam.errors import error

# fmt: off


WORD = error("steps-word",
    "found word {found} of {axis} behind {before}; expected a neighbour in the sequence {sequence}",
    "A stepping motor cannot jump; it would lose steps.")
TIME = error("steps-time",
    "found {found}; expected {expected}",
    "Rows are sent in the order of their times.")
FREQUENCY = error("steps-frequency",
    "found steps of {axis} {found} us apart; expected at least {expected} us",
    "A stepping motor that is driven faster than it can follow loses steps.")
ACCELERATION = error("steps-acceleration",
    "found {axis} at {found} mm/s2 near X {x}, Y {y}; expected at most {expected}",
    "A motor cannot jump to another speed.")
LASER = error("steps-laser",
    "found {found}; expected {expected}",
    "The laser starts and ends in the shielded corner, switched off, and pierces at rest.")
PLACE = error("steps-place",
    "found the head at X {x}, Y {y}; expected {expected}",
    "The head would be somewhere else than the drawing.")
SPEED = error("steps-speed",
    "found {found} mm/s to {process}; expected {expected}",
    "A laser that is too fast does not get through, one that is too slow burns the edge.")
VELOCITY = error("steps-velocity",
    "found {found}; expected {expected}",
    "The velocity of a segment leads from its start to its end, and the motors follow it.")
COUNT = error("steps-count",
    "found {found} steps of {axis} up to {place}; expected {expected}",
    "Steps that are missing or too many stay for all that comes behind.")
