"""Checks of what a machine file names: spindles, faces, axes and processes of its other tables, and
G and M words of its controller; and all checks of a file, in their order.
"""

import re
from collections.abc import Callable, Iterator, Set
from functools import partial
from typing import get_args

from beamcam.errors import MachineError
from beamcam.machine import faults as of
from beamcam.machine.faults import Fault, repeats
from beamcam.machine.machine import (
    CARRYING,
    CARRYING_CODE,
    OTHER_LETTERS,
    CodeMeaning,
    Machine,
    TableMeaning,
    plain_code,
    signed,
)
from beamcam.machine.stations import NoValueError, Pair, Spindle
from beamcam.machine.toml import TomlPlace
from beamcam.machine.torch import TorchProcess
from beamcam.machine.words import MISSING_KEY, WRONG_VALUE

ACROSS = ("Y", "Z")  #: letters of a spindle's axes
OF_SAW = ("angle", "saw")  #: what only a saw has an axis for


def reference_faults(machine: Machine, left_behind: Set[str] = frozenset()) -> Iterator[Fault]:
    """Each key that names an entry of another table that is not there.

    Axes of a base stay in their registers where a file over it takes their station away:
    `left_behind` has `spindles` or `saw` for them.
    """
    yield from _axis_faults(machine, left_behind)
    faces = {spindle.face for spindle in machine.spindles}
    for index, tools in enumerate(machine.tools):
        if machine.spindles and not faces.intersection(tools.faces):
            yield f"tools.{index}.faces", f"a face that has a spindle: {', '.join(sorted(faces))}"
    turning = {axis.name for axis in machine.axes if axis.moves == "angle"}
    for index, body in enumerate(machine.bodies):
        for field, carrier in zip(("x", "y", "z"), body.carriers, strict=False):
            if signed(carrier)[0] in turning:
                yield f"bodies.{index}.{field}", "an axis in millimetres"
        if body.turn and signed(body.turn)[0] not in turning:
            yield f"bodies.{index}.turn", "an axis in degrees, which moves the angle"
    if (torch := machine.torch) is not None:
        names = [(f"torch.settings.{name}", name) for name in torch.settings]
        for key, name in (*names, *(("torch.settled", name) for name in torch.settled)):
            if name not in torch.colours:
                yield key, f"a key of torch.colours: {', '.join(torch.colours)}", name
    for process in machine.triggers.outputs if machine.triggers else ():
        if process not in get_args(TorchProcess):
            expected = f"one of {', '.join(get_args(TorchProcess))}"
            yield f"triggers.outputs.{process}", expected


def _axis_faults(machine: Machine, left_behind: Set[str]) -> Iterator[Fault]:
    numbers = {spindle.number for spindle in machine.spindles}
    known = ", ".join(map(str, sorted(numbers))) or "none, there are no spindles"
    for index, _ in repeats(axis.name for axis in machine.axes):
        yield f"axes.{index}.name", "a name once"
    for index, axis in enumerate(machine.axes):
        key = f"axes.{index}"
        if axis.spindle is None:
            if axis.moves in ACROSS and machine.stock == "beam":
                yield f"{key}.spindle", f"the number of a spindle: {known}"
            if axis.moves in OF_SAW and machine.saw is None and "saw" not in left_behind:
                yield f"{key}.moves", "another motion, or a [saw] table for it"
        elif axis.spindle not in numbers and "spindles" not in left_behind:
            yield f"{key}.spindle", f"the number of a spindle: {known}"
        elif axis.moves not in ACROSS:
            yield f"{key}.moves", f"{' or '.join(ACROSS)}, which move a spindle"


# --- name faults ----------------------------------------------------------------------------------

#: DSTV codes of sections.
SECTION_CODES = ("I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO")
_SUFFIX = re.compile(r"\.[A-Za-z0-9_-]{1,16}")


def name_faults(machine: Machine) -> Iterator[Fault]:
    """Each key that names something unknown, or the same thing twice."""
    layout, known = machine.layout, ", ".join(SECTION_CODES)
    if not _SUFFIX.fullmatch(machine.suffix):
        yield "suffix", "a dot and letters or digits, such as .gcode"
    for code in machine.sections:
        if code not in SECTION_CODES:
            yield f"sections.{code}", f"a DSTV code of a section: {known}", code
    for code in layout.profiles if layout else ():
        if code not in SECTION_CODES:
            yield "layout.profiles", f"DSTV codes of sections: {known}", code
    if layout and layout.max_bar is not None and layout.min_bar > layout.max_bar:
        yield "layout.min_bar", f"at most layout.max_bar, {layout.max_bar:g}"
    for index, pair in enumerate(machine.pairs):
        if pair.faces[0] == pair.faces[1]:
            yield f"pairs.{index}.faces", "two faces"
    # Of two spindles for one face one would never run.
    for index, first in repeats(spindle.face for spindle in machine.spindles):
        expected = f"another face than that of {machine.spindles[first].name!r}"
        yield f"spindles.{index}.face", expected
    stations: list[tuple[str, Spindle | Pair]] = []
    stations += [(f"spindles.{index}", station) for index, station in enumerate(machine.spindles)]
    stations += [(f"pairs.{index}", station) for index, station in enumerate(machine.pairs)]
    for index, first in repeats(station.number for _, station in stations):
        expected = f"another number than that of {stations[first][1].name!r}"
        yield f"{stations[index][0]}.number", expected
    for index, _ in repeats((axis.moves, axis.spindle) for axis in machine.axes):
        axis = machine.axes[index]
        whose = "" if axis.spindle is None else f" of spindle {axis.spindle}"
        yield f"axes.{index}.moves", f"one axis that moves {axis.moves}{whose}"


# --- marking faults -------------------------------------------------------------------------------

_LAST_ASCII = "~"


def marking_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a stamp or printer that is missing or contradicts another."""
    marks = machine.marks
    if not marks.is_told:
        return
    if machine.stock == "sheet":
        yield "marks.unit", "scribe, plasma or laser, which draw strokes, on a table"
        return
    if not marks.characters:
        yield "marks.characters", f"the characters that the {marks.unit} has"
    for sign in marks.characters:
        if not " " <= sign <= _LAST_ASCII:
            yield "marks.characters", "printable characters of ASCII", sign
    if not marks.faces:
        yield "marks.faces", f"the faces that the {marks.unit} comes to"
    elif not {*marks.faces} <= {*"vouh"}:
        yield "marks.faces", "faces among v, o, u, h"
    elif len(set(marks.faces.values())) < len(marks.faces):
        yield "marks.faces", "a number of its own for each face"
    key, template = f"words.{marks.unit}", getattr(machine.words, marks.unit)
    lines = [line for line in template if "{string}" in line]
    if len(lines) != 1 or lines[0].count("{string}") != 1:
        yield key, "one line with {string}"
        return
    line = lines[0]
    behind = line.partition("{string}")[2][:1]
    if not behind or behind == "{" or behind in marks.characters:
        expected = "a character behind {string} that is not in marks.characters, such as a quote"
        yield key, expected, line
    # What the word carries, and whether there are several values that it tells apart.
    carried = (("y", True), ("height", len(marks.heights) != 1), ("angle", len(marks.angles) != 1),
               ("face", len(marks.faces) != 1))  # fmt: skip
    for name, is_needed in carried:
        if line.count("{" + name) > 1:
            yield key, "{" + name + "} once", line
        if is_needed and "{" + name + "}" not in line:
            yield key, "{" + name + "} beside {string}", line
    if not any("X{x}" in other for other in template if other != line):
        yield key, "a line before it with X{x}, which brings the bar there"


# --- G and M words --------------------------------------------------------------------------------


#: G words with a fixed meaning on every controller of a family, whatever a file says.
_DOCUMENTED_G = frozenset(range(7)) | {8, 9, 17, 20, 21, 40, 41, 42, 64, 75, 90, 91, 98, 99}
_DOCUMENTED_M = frozenset(range(10)) | {30}
_NAMED = re.compile(r"o<[a-z0-9_-]+>|#<[a-z0-9_-]+>(?:=-?[0-9.]+)?")
#: M words of a controller that start and stop a tool or coolant, which a table may wire otherwise.
_WIRED_M = frozenset((3, 4, 5, 7, 8, 9))
_OF_TABLES = frozenset(get_args(TableMeaning))
#: "User Defined Commands M100-M199", and M words of its own that beamcam gives no meaning.
_OWN_OF_LINUXCNC = frozenset({*range(100, 200), *range(61, 74)})
#: Controllers of which a program has G and M words.
_WORDED = ("codesys", "linuxcnc", "grbl", "mach3")
_HAS_MEANING = "another word, as the controller gives that one a meaning"


def code_faults(machine: Machine) -> Iterator[Fault]:
    """Words of `[codes]` and `allowed_codes` that are none, or cannot mean what they should."""
    check = _table_code_fault if machine.stock == "sheet" else _line_code_fault
    for code, meaning in machine.codes.items():
        if (fault := check(machine, code, meaning)) is not None:
            found, expected = fault
            yield f"codes.{code}", expected, found
    of_controller = machine.controller
    if machine.startup_code and of_controller not in ("linuxcnc", "grbl", "mach3"):
        yield "startup_code", f"none, programs of {of_controller} say all that holds"
    if machine.allowed_codes and of_controller not in _WORDED:
        yield "allowed_codes", f"none, a program of {of_controller} has no such words"
        return
    codes = [plain_code(code) for code in machine.allowed_codes]
    for index, plain in enumerate(codes):
        if plain is None:
            yield f"allowed_codes.{index}", "a G or M word such as G01 or M30"
    for index, _ in repeats(codes):
        yield f"allowed_codes.{index}", "each word once"


def _line_code_fault(machine: Machine, code: str, meaning: CodeMeaning) -> tuple[str, str] | None:
    """What is wrong with a word of a line's own or its meaning: found and expected."""
    plain = plain_code(code)
    if plain is None:
        return code, "a G word such as G81, or an M word such as M77"
    if _number(plain) in (_DOCUMENTED_G if plain[0] == "G" else _DOCUMENTED_M):
        return code, _HAS_MEANING
    if meaning != "none" and plain[0] == "M":
        return meaning, "none, as an M word switches what only a template can tell"
    if meaning in _OF_TABLES:
        return meaning, "what a word of a line does; that is one of a table's"
    if meaning != "none" and machine.controller != "codesys":
        return meaning, f"none, as {machine.controller} has cycles of its own"
    return None if plain[0] == "G" else _own_m_fault(machine, code, _number(plain))


def _table_code_fault(machine: Machine, code: str, meaning: CodeMeaning) -> tuple[str, str] | None:
    """What is wrong with a word of a table's own, and with what it is to mean."""
    lifts = machine.torch is not None and machine.torch.z == "program"
    if code in OTHER_LETTERS:
        if meaning != "none":
            return meaning, "none, a letter by itself does nothing"
        is_moved = code == "Z" and lifts
        return (meaning, "no such key, as the program moves Z (torch.z)") if is_moved else None
    if meaning not in _OF_TABLES and meaning != "none":
        return meaning, "what a word of a table does; a table does not drill"
    if meaning in ("height", "touch off") and not lifts:
        return meaning, 'another meaning, or torch.z = "program", as the controller moves Z'
    if _NAMED.fullmatch(code):
        if machine.controller != "linuxcnc":
            return code, f"a G or M word; {machine.controller} has no names"
        return (meaning, "a meaning without a number") if meaning in CARRYING else None
    carrying = CARRYING_CODE.fullmatch(code)
    plain = plain_code(carrying[1] if carrying else code)
    if plain is None:
        return code, "a G word such as G81, or an M word such as M77 or M64P2"
    number = _number(plain)
    if plain[0] == "G":
        if number in _DOCUMENTED_G:
            return code, _HAS_MEANING
        return None if meaning == "none" else (meaning, "none, as a G word switches nothing")
    if number in _WIRED_M:
        is_open = meaning == "none" and not carrying
        return (meaning, "what it switches, as it starts or stops something") if is_open else None
    return (code, _HAS_MEANING) if number in _DOCUMENTED_M else _own_m_fault(machine, code, number)


def _own_m_fault(machine: Machine, code: str, number: int) -> tuple[str, str] | None:
    """A word beyond those that a user may define on a controller."""
    if machine.controller == "linuxcnc":
        expected = "M61 to M73, or M100 to M199, the words of the user"
        return None if number in _OWN_OF_LINUXCNC else (code, expected)
    has_others = machine.controller in ("codesys", "mach3")
    return None if has_others else (code, f"no M word, {machine.controller} has no others")


def _number(plain: str) -> int:
    return int(plain[1:].partition(".")[0])


def check_keys(machine: Machine, place: TomlPlace, left_behind: frozenset[str]) -> None:
    """Raise MachineError where keys contradict each other."""
    checks: list[Callable[[Machine], Iterator[Fault]]] = [
        of.size_faults, of.template_faults, code_faults, of.number_faults,
        name_faults, partial(reference_faults, left_behind=left_behind),
        of.spindle_faults, of.tool_faults, of.pair_faults, of.view_faults, marking_faults,
    ]  # fmt: skip
    if machine.torch is not None or machine.stepper is not None:
        from beamcam.machine.torch_faults import torch_faults

        checks.insert(checks.index(of.view_faults), torch_faults)
    if machine.coper is not None:
        from beamcam.machine.coper_faults import coper_faults

        checks.append(coper_faults)
    try:
        faults = (fault for check in checks for fault in of.with_found(check(machine), machine))
        key, found, expected = next(faults, ("", None, ""))
    except NoValueError as error:
        key = next(key for key, value in of.leaves(machine) if value == error.formula)
        found, expected = error.formula, error.expected
    if key:
        source = place.child(key).source
        raise MachineError(WRONG_VALUE.at(source, key=key, found=repr(found), expected=expected))
    table = {"beam": "layout", "sheet": "torch", "profile": "coper"}[machine.stock]
    if machine.stock == "beam" and machine.saw is None and machine.drill is None:
        table = "saw" if machine.layout is not None else table
    if getattr(machine, table) is None:
        raise MachineError(MISSING_KEY.at(place.child(table).source, expected=table))
