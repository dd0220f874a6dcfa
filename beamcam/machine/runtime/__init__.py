"""The fixed part of a trigger program: the same text for every job of a machine.

The shipped Structured Text beside this file, with the names, addresses, limits and times of a
machine's file put in. What a job adds are its times and set-points, in two places:

    head | declarations of the job | middle | operations of the job | end
"""

import re
from importlib.resources import files

from msgspec import Struct
from msgspec.structs import astuple

from beamcam.caches import PerObject
from beamcam.machine.machine import Machine
from beamcam.machine.tables import DIALECTS, TableDialect, Triggers

STYLES = ("chain", "table")
PROCESSES = ("cut", "mark", "engrave")  #: switched on by the kinds 1, 3, 5, off by 2, 4, 6
STOP_BRAKES = 2.0  #: a stop brakes so many times as hard as work does
#: Variables of the inputs, in the order of `Triggers.inputs`; TRUE is actuated.
INPUTS = (
    "limitXLow", "limitXHigh", "limitYLow", "limitYHigh", "startButton", "acknowledgeButton",
    "stopButton", "limitZLow", "limitZHigh",
)  # fmt: skip
#: Words of the text for homing: of an axis that homes down, and of one that homes up.
HOMING = {
    "block": ("FB_Home", "FB_HomeUp"), "low": ("low", "high"), "high": ("high", "low"),
    "Low": ("Low", "High"), "High": ("High", "Low"), "away": ("POSITIVE", "NEGATIVE"),
    "towards": ("NEGATIVE", "POSITIVE"), "out": ("+", "-"), "in": ("-", "+"),
    "is out to": (">=", "<="), "is out of": (">", "<"), "is in of": ("<", ">"),
    "own": ("", "Z_"), "z": ("", "z_"), "sign": ("", "-"), "home": ("LREAL#0.0", "Z_HOME"),
    "back off to": ("to the corner of the work area", "to where the torch is at home"),
}  # fmt: skip
_INDENT = " " * 8
_INCLUDE = re.compile(r"^<include (\w+)>\n", re.MULTILINE)
_IF_UP = re.compile(r"\{up ?([^{}]*)\}")  #: {up what homing up has besides}
_OF_Z = re.compile(r"\{(!?)z ?([^{}]*)\}")  #: {z what a table with a Z has}, {!z one without}


class Runtime(Struct, frozen=True):
    """The three pieces of the fixed part, each of whole lines."""

    head: str
    middle: str
    end: str


def runtime_of(machine: Machine, style: str) -> Runtime:
    """The fixed part of a machine's programs, for a job in the style "chain" or "table".

    Raises TypeError for a machine without a trigger program.
    """
    return _all_styles(machine)[style]


def library_runtime(machine: Machine, style: str) -> Runtime:
    """The same, with the names of the controller's library as the manuals have them."""
    triggers = machine.needed(machine.triggers, "trigger program")
    dialect, has_z = dialect_of(machine), triggers.z is not None
    text = _INCLUDE.sub(lambda mark: shipped(mark[1]), shipped(dialect.text))
    # What it has for one style goes from the style's mark up to the next one.
    text, *pieces = re.split(rf"^<({'|'.join(STYLES)}|)>\n", text, flags=re.MULTILINE)
    marks = zip(pieces[::2], pieces[1::2], strict=True)
    text += "".join(piece for mark, piece in marks if mark in ("", style))
    homing = shipped(dialect.homing)
    text = text.replace("<homing>\n", _of_homing(homing, 0) + _of_homing(homing, 1) * has_z)
    text = text.replace("<motion>\n", shipped("paths" if triggers.path_objects else "lines"))
    text = text.replace("<operations>\n", shipped(style))
    text = _OF_Z.sub(lambda mark: mark[2] if (mark[1] == "") == has_z else "", text)
    for name, lines in _lines(triggers).items():
        form = re.compile(rf"^( *)<{name}>\n", re.MULTILINE)
        for indent in form.findall(text):
            own = "".join(f"{indent or _INDENT}{line}\n" for line in lines)
            text = form.sub(lambda _, own=own: own, text, count=1)  # type: ignore[misc]
    for name, value in _values(triggers).items():
        text = text.replace(f"<{name}>", value)
    return Runtime(*text.split("@\n"))


def dialect_of(machine: Machine) -> TableDialect:
    """The dialect of a machine's trigger programs. Raises KeyError for a machine without any."""
    return DIALECTS[machine.controller]


def lreal(value: float) -> str:
    """A literal of the type LREAL, to six decimals."""
    plain = f"{round(value, 6) + 0.0:.6f}".rstrip("0")
    return f"LREAL#{plain}0" if plain.endswith(".") else f"LREAL#{plain}"


def _values(t: Triggers) -> dict[str, str]:
    """What stands for each name of one word in the shipped text."""
    numbers = (
        "in_position", "standstill", "arrival_window", "acceleration", "homing_mm_s", "back_off",
        "cycle_s", "max_homing_s", "max_late_s", "following_lag_s", "homing_slow_mm_s",
        "homing_window", "late_factor",
    )  # fmt: skip
    of_z = {} if t.z is None else {
        "axis_z": t.z.axis, "z_arrival_window": lreal(t.z.arrival_window),
        "z_homing_window": lreal(t.lift_window), "z_back_off": lreal(t.z.back_off),
        "z_home": lreal(t.z.home_height), "z_home_place": lreal(t.z.home_height),
        "z_home_position": lreal(t.z.home_height + t.z.back_off),
    }  # fmt: skip
    return {
        **of_z,
        "axis_x": t.axes[0],
        "axis_y": t.axes[1],
        "path_object": t.path_object,
        "package": t.technology,
        "cycle_ms": f"{1000 * t.cycle_s:g}",
        "home_place": lreal(0.0),
        "home_position": lreal(-t.back_off),
        "far": lreal(t.homing_mm_s * t.max_homing_s),
        "stop_deceleration": lreal(STOP_BRAKES * t.acceleration),
        **{name: lreal(getattr(t, name)) for name in numbers},
    }


def _lines(t: Triggers) -> dict[str, list[str]]:
    """The lines that declare inputs and outputs, and those that copy what has a name."""
    inputs = dict(zip(INPUTS, t.inputs, strict=False))  # the last two are those of Z
    outputs = {f"{process}On": t.outputs.get(process, "") for process in PROCESSES}
    # An input that is TRUE while nothing is the matter is read under another name, and turned.
    wires = {name: name for name in inputs}
    wires |= {name: f"{name}Wire" for name, place in inputs.items() if place in t.normally_closed}
    declared, reads = [], []
    for name, place in inputs.items():
        read = wires[name] if is_address(place) else place
        if is_address(place):
            declared.append(f"{read} AT {place} : BOOL;")
        if read != name:
            declared.append(f"{name} : BOOL := FALSE;")
        if read not in ("", name):
            turned = "NOT " if place in t.normally_closed else ""
            reads.append(f"{name} := {turned}{read};")
    declared += [
        f"{name} AT {place} : BOOL;" if is_address(place) else f"{name} : BOOL := FALSE;"
        for name, place in outputs.items()
    ]
    writes = [f"{other} := {name};" for name, other in outputs.items()
              if other and not is_address(other)]  # fmt: skip
    lamp = t.fault_lamp
    if is_address(lamp):
        declared.append(f"faultLamp AT {lamp} : BOOL;")
    shown = [f"{'faultLamp' if is_address(lamp) else lamp} := workFault;"] if lamp else []
    others = [f"{place} : BOOL;" for place in (*t.inputs, *outputs.values(), lamp)
              if place and not is_address(place)]  # fmt: skip
    return {
        "inputs and outputs": declared,
        "external inputs and outputs": [f"{line.split()[0]} : BOOL;" for line in declared + others],
        "named inputs and outputs": others,
        "read inputs": reads,
        "write outputs": writes,
        "show fault": shown,
    }


def is_address(place: str) -> bool:
    """Whether an input or output is an address such as %I0.0; else it is a variable's name."""
    return place.startswith("%")


def _of_homing(text: str, up: int) -> str:
    """The text for homing, of an axis that homes down or up."""
    for word, own in HOMING.items():
        text = text.replace(f"<{word}>", own[up])
    return _IF_UP.sub(lambda mark: mark[1] if up else "", text)


def shipped(name: str) -> str:
    """A text that stands beside this file."""
    return (files(__package__) / f"{name}.st").read_text(encoding="ascii")


def _make(machine: Machine) -> dict[str, Runtime]:
    """The text of each style, with names of the library as the project's package has them."""
    runtimes = {style: library_runtime(machine, style) for style in STYLES}
    names = machine.triggers.names if machine.triggers else {}
    if not names:
        return runtimes
    longest_first = sorted(names, key=len, reverse=True)
    words = re.compile(rf"(?<!\w)(?:{'|'.join(map(re.escape, longest_first))})(?!\w)")
    return {
        style: Runtime(*(words.sub(lambda word: names[word[0]], text) for text in astuple(plain)))
        for style, plain in runtimes.items()
    }


_all_styles = PerObject("simotion.runtime", _make)
