"""Rules for trigger programs."""

from beamcam.errors import error

# fmt: off


SYNTAX = error("st-syntax",
    "found {found!r}; expected {expected}",
    "The controller's compiler would refuse the unit.")
NAME = error("st-name",
    "found {found}, which is not declared; expected {expected}",
    "A misspelt name is refused by the compiler, or worse, is another variable.")
DECLARED = error("st-declaration",
    "found the name {found} {how}; expected {expected}",
    "A name stands for one thing; keywords of the language and its assembler are no names.")
PARAMETER = error("st-parameter",
    "found {found} in a call of {callee}; expected {expected}",
    "A command without a parameter runs with the project's default, which is unknown here.")
TYPE = error("st-type",
    "found {found} for {what}; expected {expected}",
    "Types that do not fit are refused by the compiler.")
BOUNDS = error("st-bounds",
    "found index {found} of {name}; expected {low} to {high}",
    "An index outside of its array stops the controller.")
COUNT = error("st-array",
    "found {found} values for {name}; expected {expected}",
    "An array that is not filled ends at the machine's corner.")
RUN = error("st-run",
    "found {found}; expected {expected}",
    "The program was run with simulated axes, and this happened.")
RUNTIME = error("st-runtime",
    "found {found!r} in the fixed part of the program; expected {expected!r}",
    "Homing, limits, faults and triggers are the same text for every job of a machine.")
COMMAND = error("st-command",
    "found {found}; expected {expected}",
    "The axis would refuse the command, or do something else than is meant.")
TRIGGER = error("st-trigger",
    "found {found}; expected {expected}",
    "Each operation is started once, when the one before it has arrived.")
TOOL = error("st-tool",
    "found {found}; expected {expected}",
    "The tool burns where it should not, or does not pierce.")
STRAIGHT = error("st-straight",
    "found a {what} at {found}; expected it at {expected}, where the head stands",
    "The next line is computed from there, and its axes would not arrive together.")
SPEED = error("st-speed",
    "found {found} mm/s to {what}; expected {expected} mm/s",
    "The torch does not cut through, or the axis cannot follow.")

HEIGHT = error("st-height",
    "found {found}; expected {expected}",
    "The torch pierces and cuts at the heights of its row; with it off X and Y move at clearance.")
