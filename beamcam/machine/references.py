"""Checks of what a machine file names: spindles, faces, axes and processes of its other tables, and
G and M words of its controller; and all checks of a file, in their order.
"""

import re
from collections.abc import Callable, Iterator, Set
from functools import partial
from typing import Literal, get_args

from beamcam.errors import MachineError
from beamcam.machine import faults as of
from beamcam.machine.bodies import signed
from beamcam.machine.faults import Fault
from beamcam.machine.machine import (
    CARRYING,
    CARRYING_CODE,
    OTHER_LETTERS,
    CodeMeaning,
    Machine,
    TableMeaning,
    plain_code,
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
    yield from _tool_faults(machine)
    yield from _carrier_faults(machine)
    yield from _look_faults(machine)
    if machine.triggers is not None:
        for process, place in machine.triggers.outputs.items():
            if process not in get_args(TorchProcess):
                expected = f"one of {', '.join(get_args(TorchProcess))}"
                yield f"triggers.outputs.{process}", place, expected


def _axis_faults(machine: Machine, left_behind: Set[str]) -> Iterator[Fault]:
    numbers = {spindle.number for spindle in machine.spindles}
    known = ", ".join(map(str, sorted(numbers))) or "none, there are no spindles"
    names: set[str] = set()
    for index, axis in enumerate(machine.axes):
        key = f"axes.{index}"
        if axis.name in names:
            yield f"{key}.name", axis.name, "a name once"
        names.add(axis.name)
        if axis.spindle is None:
            if axis.moves in ACROSS and machine.stock == "beam":
                yield f"{key}.spindle", None, f"the number of a spindle: {known}"
            if axis.moves in OF_SAW and machine.saw is None and "saw" not in left_behind:
                yield f"{key}.moves", axis.moves, "another motion, or a [saw] table for it"
        elif axis.spindle not in numbers and "spindles" not in left_behind:
            yield f"{key}.spindle", axis.spindle, f"the number of a spindle: {known}"
        elif axis.moves not in ACROSS:
            yield f"{key}.moves", axis.moves, f"{' or '.join(ACROSS)}, which move a spindle"


def _tool_faults(machine: Machine) -> Iterator[Fault]:
    faces = {spindle.face for spindle in machine.spindles}
    for index, tools in enumerate(machine.tools):
        if machine.spindles and not faces.intersection(tools.faces):
            expected = f"a face that has a spindle: {', '.join(sorted(faces))}"
            yield f"tools.{index}.faces", list(tools.faces), expected


def _carrier_faults(machine: Machine) -> Iterator[Fault]:
    """Bodies that an axis in degrees carries along, or one in millimetres turns."""
    turning = {axis.name for axis in machine.axes if axis.moves == "angle"}
    for index, body in enumerate(machine.bodies):
        for field, carrier in zip(("x", "y", "z"), body.carriers, strict=False):
            if signed(carrier)[0] in turning:
                yield f"bodies.{index}.{field}", carrier, "an axis in millimetres"
        if body.turn and signed(body.turn)[0] not in turning:
            yield f"bodies.{index}.turn", body.turn, "an axis in degrees, which moves the angle"


def _look_faults(machine: Machine) -> Iterator[Fault]:
    torch = machine.torch
    if torch is None:
        return
    for name in torch.settings:
        if name not in torch.colours:
            known = ", ".join(torch.colours)
            yield f"torch.settings.{name}", name, f"a key of torch.colours: {known}"
    for name in torch.settled:
        if name not in torch.colours:
            known = ", ".join(torch.colours)
            yield "torch.settled", name, f"a key of torch.colours: {known}"


# --- name faults ----------------------------------------------------------------------------------

# Checks of what a machine's keys name: axes, faces, sections, suffixes.


#: DSTV codes of sections.
SECTION_CODES = ("I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO")
_SUFFIX = re.compile(r"\.[A-Za-z0-9_-]{1,16}")


def name_faults(machine: Machine) -> Iterator[Fault]:
    """Each key that names something unknown, or the same thing twice."""
    if not _SUFFIX.fullmatch(machine.suffix):
        yield "suffix", machine.suffix, "a dot and letters or digits, such as .gcode"
    known = ", ".join(SECTION_CODES)
    for code in machine.sections:
        if code not in SECTION_CODES:
            yield f"sections.{code}", code, f"a DSTV code of a section: {known}"
    if machine.layout is not None:
        layout = machine.layout
        for code in layout.profiles:
            if code not in SECTION_CODES:
                yield "layout.profiles", code, f"DSTV codes of sections: {known}"
        if layout.max_bar is not None and layout.min_bar > layout.max_bar:
            yield "layout.min_bar", layout.min_bar, f"at most layout.max_bar, {layout.max_bar:g}"
    for index, pair in enumerate(machine.pairs):
        if pair.faces[0] == pair.faces[1]:
            yield f"pairs.{index}.faces", list(pair.faces), "two faces"
    yield from _spindle_faults(machine)
    yield from _moved_faults(machine)


def _spindle_faults(machine: Machine) -> Iterator[Fault]:
    """Spindles for one face, of which one would never run, and numbers that two of them have."""
    faces: dict[str, str] = {}
    for index, spindle in enumerate(machine.spindles):
        if spindle.face in faces:
            expected = f"another face than that of {faces[spindle.face]!r}"
            yield f"spindles.{index}.face", spindle.face, expected
        faces[spindle.face] = spindle.name
    stations: list[tuple[str, Spindle | Pair]] = []
    stations += [(f"spindles.{index}", station) for index, station in enumerate(machine.spindles)]
    stations += [(f"pairs.{index}", station) for index, station in enumerate(machine.pairs)]
    numbers: dict[int, str] = {}
    for key, station in stations:
        if station.number in numbers:
            expected = f"another number than that of {numbers[station.number]!r}"
            yield f"{key}.number", station.number, expected
        numbers[station.number] = station.name


def _moved_faults(machine: Machine) -> Iterator[Fault]:
    seen: set[tuple[str, int | None]] = set()
    for index, axis in enumerate(machine.axes):
        moved = axis.moves, axis.spindle
        if moved in seen:
            whose = "" if axis.spindle is None else f" of spindle {axis.spindle}"
            yield f"axes.{index}.moves", axis.moves, f"one axis that moves {axis.moves}{whose}"
        seen.add(moved)


# --- marking faults -------------------------------------------------------------------------------

# Checks of a stamp or printer: what it has, and the word that tells it a text.


_LAST_ASCII = "~"
#: What the word with the text has to carry, and the key whose values it tells apart.
_CARRIED = (("height", "heights"), ("angle", "angles"), ("face", "faces"))


def marking_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a stamp or printer that is missing or contradicts another."""
    marks = machine.marks
    if not marks.is_told:
        return
    if machine.stock == "sheet":
        yield "marks.unit", marks.unit, "scribe, plasma or laser, which draw strokes, on a table"
        return
    if not marks.characters:
        yield "marks.characters", "", f"the characters that the {marks.unit} has"
    for sign in marks.characters:
        if not " " <= sign <= _LAST_ASCII:
            yield "marks.characters", sign, "printable characters of ASCII"
    if not marks.faces:
        yield "marks.faces", {}, f"the faces that the {marks.unit} comes to"
    elif not {*marks.faces} <= {*"vouh"}:
        yield "marks.faces", dict(marks.faces), "faces among v, o, u, h"
    elif len(set(marks.faces.values())) < len(marks.faces):
        yield "marks.faces", dict(marks.faces), "a number of its own for each face"
    if not marks.angles:
        yield "marks.angles", [], "at least one angle"
    yield from _place_faults(machine)
    yield from _word_faults(machine)


def _place_faults(machine: Machine) -> Iterator[Fault]:
    """A unit that the bar passes in the wrong order."""
    x, saw, layout = machine.marks.x, machine.saw, machine.layout
    if x is None or saw is None or layout is None:
        return
    if layout.order == "saw-drill" and x < saw.x:
        yield "marks.x", x, "at least saw.x, since the bar reaches the saw first"
    if layout.order == "drill-saw" and x > saw.x:
        yield "marks.x", x, "at most saw.x, or the part is cut off before"


def _word_faults(machine: Machine) -> Iterator[Fault]:
    """What is wrong with the template that tells the unit a text."""
    marks, key = machine.marks, f"words.{machine.marks.unit}"
    template = getattr(machine.words, marks.unit)
    telling = [line for line in template if "{string}" in line]
    if len(telling) != 1 or telling[0].count("{string}") != 1:
        yield key, list(template), "one line with {string}"
        return
    behind = telling[0].partition("{string}")[2][:1]
    if not behind or behind == "{" or behind in marks.characters:
        expected = "a character behind {string} that is not in marks.characters, such as a quote"
        yield key, telling[0], expected
    for name in ("y", *(name for name, _ in _CARRIED)):
        if telling[0].count("{" + name) > 1:
            yield key, telling[0], "{" + name + "} once"
    needed = ["y", *(name for name, of in _CARRIED if len(getattr(marks, of)) != 1)]
    for name in needed:
        if "{" + name + "}" not in telling[0]:
            yield key, telling[0], "{" + name + "} beside {string}"
    if not any("X{x}" in line for line in template if line not in telling):
        yield key, list(template), "a line before it with X{x}, which brings the bar there"


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


def code_faults(machine: Machine) -> Iterator[Fault]:
    """Words of `[codes]` and `allowed_codes` that are none, or cannot mean what they should."""
    for code, meaning in machine.codes.items():
        key = f"codes.{code}"
        if machine.stock == "sheet":
            yield from _table_code_faults(machine, code, meaning)
            continue
        plain = plain_code(code)
        if plain is None:
            yield key, code, "a G word such as G81, or an M word such as M77"
        elif _number(plain) in (_DOCUMENTED_G if plain[0] == "G" else _DOCUMENTED_M):
            yield key, code, "another word, as the controller gives that one a meaning"
        elif meaning != "none" and plain[0] == "M":
            yield key, meaning, "none, as an M word switches what only a template can tell"
        elif meaning in _OF_TABLES:
            yield key, meaning, "what a word of a line does; that is one of a table's"
        elif meaning != "none" and machine.controller != "codesys":
            yield key, meaning, f"none, as {machine.controller} has cycles of its own"
        elif plain[0] == "M" and not _takes_own_m(machine, _number(plain)):
            yield (
                key,
                code,
                "M61 to M73, or M100 to M199, the words of the user"
                if (machine.controller == "linuxcnc")
                else f"no M word, {machine.controller} has no others",
            )
    if machine.startup_code and machine.controller not in ("linuxcnc", "grbl", "mach3"):
        expected = f"none, programs of {machine.controller} say all that holds"
        yield "startup_code", machine.startup_code, expected
    yield from _allowed_code_faults(machine)


def _table_code_faults(machine: Machine, code: str, meaning: CodeMeaning) -> Iterator[Fault]:
    """What is wrong with a word of a table's own, and with what it is to mean."""
    key, of = f"codes.{code}", machine.controller
    torch = machine.torch
    if code in OTHER_LETTERS:
        if meaning != "none":
            yield key, meaning, "none, a letter by itself does nothing"
        elif code == "Z" and torch is not None and torch.z == "program":
            yield key, meaning, "no such key, as the program moves Z (torch.z)"
        return
    if meaning not in _OF_TABLES and meaning != "none":
        yield key, meaning, "what a word of a table does; a table does not drill"
        return
    if meaning in ("height", "touch off") and (torch is None or torch.z != "program"):
        yield key, meaning, 'another meaning, or torch.z = "program", as the controller moves Z'
        return
    if _NAMED.fullmatch(code):
        if of != "linuxcnc":
            yield key, code, f"a G or M word; {of} has no names"
        elif meaning in CARRYING:
            yield key, meaning, "a meaning without a number"
        return
    carrying = CARRYING_CODE.fullmatch(code)
    plain = plain_code(carrying[1] if carrying else code)
    if plain is None:
        yield key, code, "a G word such as G81, or an M word such as M77 or M64P2"
        return
    number = _number(plain)
    if plain[0] == "G" and (number in _DOCUMENTED_G or meaning != "none"):
        if number in _DOCUMENTED_G:
            yield key, code, "another word, as the controller gives that one a meaning"
        else:
            yield key, meaning, "none, as a G word switches nothing"
    elif plain[0] == "M" and number in _DOCUMENTED_M - _WIRED_M:
        yield key, code, "another word, as the controller gives that one a meaning"
    elif plain[0] == "M" and number in _WIRED_M and meaning == "none" and not carrying:
        yield key, meaning, "what it switches, as it starts or stops something"
    elif plain[0] == "M" and number not in _WIRED_M and not _takes_own_m(machine, number):
        expected = "M61 to M73, or M100 to M199, the words of the user"
        yield key, code, expected if of == "linuxcnc" else f"no M word, {of} has no others"


def _allowed_code_faults(machine: Machine) -> Iterator[Fault]:
    worded: tuple[Literal["codesys"], ...] | tuple[str, ...]
    worded = ("codesys", "linuxcnc", "grbl", "mach3")
    if machine.allowed_codes and machine.controller not in worded:
        codes = list(machine.allowed_codes)
        yield "allowed_codes", codes, f"none, a program of {machine.controller} has no such words"
        return
    seen: set[str] = set()
    for index, code in enumerate(machine.allowed_codes):
        plain = plain_code(code)
        if plain is None:
            yield f"allowed_codes.{index}", code, "a G or M word such as G01 or M30"
        elif plain in seen:
            yield f"allowed_codes.{index}", code, "each word once"
        else:
            seen.add(plain)


def _number(plain: str) -> int:
    return int(plain[1:].partition(".")[0])


def _takes_own_m(machine: Machine, number: int) -> bool:
    if machine.controller == "linuxcnc":
        return number in _OWN_OF_LINUXCNC
    return machine.controller in ("codesys", "mach3")


def check_keys(machine: Machine, place: TomlPlace, left_behind: frozenset[str]) -> None:
    """Raise MachineError where keys contradict each other."""
    try:
        _check_each(machine, place, left_behind)
    except NoValueError as error:
        key = next(key for key, value in of.leaves(machine) if value == error.formula)
        diagnostic = WRONG_VALUE.at(
            place.child(key).source, key=key, found=repr(error.formula), expected=error.expected
        )
        raise MachineError(diagnostic) from None


def _check_each(machine: Machine, place: TomlPlace, left_behind: frozenset[str]) -> None:
    checks: list[Callable[[Machine], Iterator[Fault]]] = [
        of.size_faults, of.template_faults, code_faults, of.number_faults,
        name_faults, partial(reference_faults, left_behind=left_behind),
        of.spindle_faults, of.tool_faults, of.pair_faults, of.view_faults,
        marking_faults, of.range_faults,
    ]  # fmt: skip
    if machine.torch is not None or machine.stepper is not None:
        from beamcam.machine.torch_faults import table_range_faults, torch_faults

        checks.insert(checks.index(of.view_faults), torch_faults)
        checks.append(table_range_faults)
    if machine.coper is not None:
        from beamcam.machine.coper_faults import coper_faults

        checks.append(coper_faults)
    for faults in checks:
        for key, found, expected in faults(machine):
            source = place.child(key).source
            diagnostic = WRONG_VALUE.at(source, key=key, found=repr(found), expected=expected)
            raise MachineError(diagnostic)
    table = {"beam": "layout", "sheet": "torch", "profile": "coper"}[machine.stock]
    if getattr(machine, table) is None:
        raise MachineError(MISSING_KEY.at(place.child(table).source, expected=table))
    if machine.stock == "beam" and machine.saw is None and machine.drill is None:
        raise MachineError(MISSING_KEY.at(place.child("saw").source, expected="saw"))
