"""SIMOTION's library: types, commands with their parameters, enumerators, function blocks.

A command has to name what is `needed` here: what it leaves out would be a default of the project.
What the simulated axes do not know, such as blending, is no parameter here either.

Sources. `_pos` with its parameters up to `positiveAccel`, and `basicMotion.position`, the actual
position: a program that ran on a D425 with firmware 4.0. `positioningState`: a third party.
`_movePathLinear`, `_movePathCircular`, `_stopPath`, `_stop`, `pathPlane`, `pathMode`, `x`, `y`,
`z`, `circularType` and its values, `ijkMode`, `i`, `j`, `k`, `mergeMode` and its values,
`nextCommand`, `velocityProfile`, `velocity`, `positiveAccel`, `negativeAccel`, `pathObjectType`:
manual TO Path Interpolation 11/2010, chapters 2.5, 2.8 and 5.1. TON, ABS, SQRT: IEC 61131-3.
`UNCONFIRMED` in machine/dialects.py lists what no source shows; a machine's file can say that the
project's package calls it otherwise.
"""

from collections.abc import Sequence

from msgspec import Struct

from beamcam.controllers.simotion.syntax import Block, Variable

Type = str  #: a plain type, "axis", "path", "enum:A|B" or the name of a function block

INTEGERS = {
    "SINT": (-(2**7), 2**7 - 1), "USINT": (0, 2**8 - 1), "INT": (-(2**15), 2**15 - 1),
    "UINT": (0, 2**16 - 1), "DINT": (-(2**31), 2**31 - 1), "UDINT": (0, 2**32 - 1),
}  # fmt: skip
NUMBERS = (*INTEGERS, "REAL", "LREAL")
AXIS, PATH_OBJECT = "posAxis", "pathObjectType"
PLAIN_TYPES = (*NUMBERS, "BOOL", "TIME")
TYPES = (*PLAIN_TYPES, AXIS, PATH_OBJECT)

FUNCTIONS = ("ABS", "SQRT")
LOGIC = ("AND", "OR", "XOR")
GIVES_BOOL = (*LOGIC, "=", "<>", "<", ">", "<=", ">=")
ANSWER = "DINT"  #: type of what a command gives back

_WHEN = "enum:IMMEDIATELY|WHEN_BUFFER_READY|WHEN_COMMAND_DONE|WHEN_MOTION_DONE"
_MERGE = "enum:IMMEDIATELY|NEXT_MOTION|SEQUENTIAL|SUPERIMPOSED_MOTION_MERGE"
_DIRECT = "enum:DIRECT|USER_DEFAULT|CURRENT"
_PROFILE = "enum:TRAPEZOIDAL|SMOOTH"
_STOP = "enum:STOP_AND_ABORT|STOP_WITHOUT_ABORT"


class Command(Struct, frozen=True):
    """A system function."""

    parameters: dict[str, Type]
    needed: tuple[str, ...]


_DYNAMICS = {
    "velocityType": _DIRECT, "velocity": "LREAL",
    "positiveAccelType": _DIRECT, "positiveAccel": "LREAL",
    "negativeAccelType": _DIRECT, "negativeAccel": "LREAL",
    "velocityProfile": _PROFILE, "mergeMode": _MERGE, "nextCommand": _WHEN,
}  # fmt: skip
_PLANE = {
    "pathObject": PATH_OBJECT, "pathPlane": "enum:X_Y|Y_Z|Z_X|X_Y_Z",
    "pathMode": "enum:ABSOLUTE|RELATIVE", "x": "LREAL", "y": "LREAL", "z": "LREAL",
}  # fmt: skip

COMMANDS = {
    "_pos": Command(
        {
            "axis": AXIS, "direction": "enum:POSITIVE|NEGATIVE|BY_VALUE|SHORTEST_WAY",
            "positioningMode": "enum:ABSOLUTE|RELATIVE", "position": "LREAL", **_DYNAMICS,
        },
        ("axis", "direction", "positioningMode", "position", *_DYNAMICS),
    ),
    "_move": Command(
        {"axis": AXIS, "direction": "enum:POSITIVE|NEGATIVE|BY_VALUE", **_DYNAMICS},
        ("axis", "direction", "velocityType", "velocity", "nextCommand"),
    ),
    "_stop": Command(
        {"axis": AXIS, "stopMode": _STOP, "nextCommand": _WHEN},
        ("axis", "stopMode", "nextCommand"),
    ),
    "_stopPath": Command(
        {"pathObject": PATH_OBJECT, "stopMode": _STOP, "nextCommand": _WHEN},
        ("pathObject", "stopMode", "nextCommand"),
    ),
    "_enableAxis": Command({"axis": AXIS, "nextCommand": _WHEN}, ("axis", "nextCommand")),
    "_resetAxisError": Command(
        {"axis": AXIS, "errorResetMode": "enum:ALL_ERRORS", "nextCommand": _WHEN},
        ("axis", "errorResetMode", "nextCommand"),
    ),
    "_homing": Command(
        {
            "axis": AXIS, "homingMode": "enum:DIRECT_HOMING|ACTIVE_HOMING|PASSIVE_HOMING",
            "homePositionType": _DIRECT, "homePosition": "LREAL", "nextCommand": _WHEN,
        },
        ("axis", "homingMode", "homePositionType", "homePosition", "nextCommand"),
    ),
    "_movePathLinear": Command(
        {**_PLANE, **_DYNAMICS}, ("pathObject", "pathPlane", "pathMode", "x", "y", *_DYNAMICS)
    ),
    "_movePathCircular": Command(
        {
            **_PLANE,
            "circularType": "enum:OVER_POSITION_TO_ENDPOSITION|WITH_RADIUS_AND_ENDPOSITION",
            "ijkMode": "enum:ABSOLUTE|RELATIVE", "i": "LREAL", "j": "LREAL", "k": "LREAL",
            **_DYNAMICS,
        },
        ("pathObject", "pathPlane", "circularType", "pathMode", "x", "y", "ijkMode", "i", "j",
         *_DYNAMICS),
    ),
}  # fmt: skip

#: Standard function blocks, as if they were declared.
BLOCKS = {
    "TON": Block(0, "FUNCTION_BLOCK", "TON", (
        Variable(0, "IN", "input", "BOOL"), Variable(0, "PT", "input", "TIME"),
        Variable(0, "Q", "output", "BOOL"), Variable(0, "ET", "output", "TIME"),
    ), ()),
}  # fmt: skip

#: System variables: of an axis, and of what they hold.
COMPONENTS = {
    AXIS: {
        "control": "enum:ACTIVE|INACTIVE", "error": "enum:YES|NO",
        "basicMotion": "basicMotion", "positioningState": "positioningState",
    },
    "basicMotion": {"position": "LREAL", "velocity": "LREAL"},
    "positioningState": {"commandPosition": "LREAL", "actualPosition": "LREAL"},
}  # fmt: skip


#: The types that a value of each may be assigned to besides its own, without a conversion.
_WIDER = {
    "USINT": ("INT", "UINT", "DINT", "UDINT"), "SINT": ("INT", "DINT"), "INT": ("DINT",),
    "UINT": ("DINT", "UDINT"), "REAL": ("LREAL",), "integer": tuple(INTEGERS),
    "real": ("REAL", "LREAL"),
}  # fmt: skip


def choices(type_: Type) -> Sequence[str]:
    """The enumerators of an enumeration; none of any other type."""
    return type_[5:].split("|") if type_.startswith("enum:") else ()


ENUMERATORS = frozenset({"ACTIVE", "INACTIVE", "YES", "NO"}).union(
    *(choices(type_) for command in COMMANDS.values() for type_ in command.parameters.values())
)


def fits(found: Type, wanted: Type) -> bool:
    """Whether a value of one type is assignable to another, without a conversion."""
    if found == wanted or wanted in _WIDER.get(found, ()):
        return True
    return bool(choices(found)) and set(choices(found)) <= set(choices(wanted))


def shown(type_: Type) -> str:
    """A type as a message says it."""
    plain = " or ".join(choices(type_)) or type_
    return {"integer": "a whole number", "real": "a number with a point"}.get(plain, plain)
