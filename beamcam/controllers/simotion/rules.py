"""Rules for trigger programs."""

from beamcam.errors import Rule, Severity

_E = Severity.ERROR

SYNTAX = Rule(
    "st-syntax",
    _E,
    "found {found!r}; expected {expected}",
    "The controller's compiler would refuse the unit.",
)
NAME = Rule(
    "st-name",
    _E,
    "found {found}, which is not declared; expected {expected}",
    "A misspelt name is refused by the compiler, or worse, is another variable.",
)
DECLARED = Rule(
    "st-declaration",
    _E,
    "found the name {found} {how}; expected {expected}",
    "A name stands for one thing; keywords of the language and its assembler are no names.",
)
PARAMETER = Rule(
    "st-parameter",
    _E,
    "found {found} in a call of {callee}; expected {expected}",
    "A command without a parameter runs with the project's default, which is unknown here.",
)
TYPE = Rule(
    "st-type",
    _E,
    "found {found} for {what}; expected {expected}",
    "Types that do not fit are refused by the compiler.",
)
BOUNDS = Rule(
    "st-bounds",
    _E,
    "found index {found} of {name}; expected {low} to {high}",
    "An index outside of its array stops the controller.",
)
COUNT = Rule(
    "st-array",
    _E,
    "found {found} values for {name}; expected {expected}",
    "An array that is not filled ends at the machine's corner.",
)
RUN = Rule(
    "st-run",
    _E,
    "found {found}; expected {expected}",
    "The program was run with simulated axes, and this happened.",
)
RUNTIME = Rule(
    "st-runtime",
    _E,
    "found {found!r} in the fixed part of the program; expected {expected!r}",
    "Homing, limits, faults and triggers are the same text for every job of a machine.",
)
COMMAND = Rule(
    "st-command",
    _E,
    "found {found}; expected {expected}",
    "The axis would refuse the command, or do something else than is meant.",
)
TRIGGER = Rule(
    "st-trigger",
    _E,
    "found {found}; expected {expected}",
    "Each operation is started once, when the one before it has arrived.",
)
TOOL = Rule(
    "st-tool",
    _E,
    "found {found}; expected {expected}",
    "The tool burns where it should not, or does not pierce.",
)
STRAIGHT = Rule(
    "st-straight",
    _E,
    "found a {what} at {found}; expected it at {expected}, where the head stands",
    "The next line is computed from there, and its axes would not arrive together.",
)
SPEED = Rule(
    "st-speed",
    _E,
    "found {found} mm/s to {what}; expected {expected} mm/s",
    "The torch does not cut through, or the axis cannot follow.",
)

HEIGHT = Rule(
    "st-height",
    _E,
    "found {found}; expected {expected}",
    "The torch pierces and cuts at the heights of its row; with it off X and Y move at clearance.",
)

RULES = (
    SYNTAX, NAME, DECLARED, PARAMETER, TYPE, BOUNDS, COUNT, RUN, RUNTIME, COMMAND, TRIGGER, TOOL,
    STRAIGHT, SPEED, HEIGHT,
)  # fmt: skip
