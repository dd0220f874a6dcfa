"""G and M words: those that a machine's file gives a meaning, and all that its controller takes.

G81, M77           a word, whatever it carries
M64P2              a word with what tells it from its like
o<probe>           a call of a subroutine, LinuxCNC's
#<holes>           a value that is set by its name, LinuxCNC's
Z                  a letter of a table that beamcam does not follow
"""

import re
from collections.abc import Iterator, Mapping
from typing import Literal, get_args

from beamcam.machine.machine import CodeMeaning, Machine, TableMeaning

CodeFault = tuple[str, object, str]  #: dotted key, what was found, what was expected

#: G words with a fixed meaning on every controller of a family, whatever a file says.
_DOCUMENTED_G = frozenset(range(7)) | {8, 9, 17, 20, 21, 40, 41, 42, 64, 75, 90, 91, 98, 99}
_DOCUMENTED_M = frozenset(range(10)) | {30}
_CODE = re.compile(r"([GM])(\d{1,3})(\.\d)?")
_CARRYING = re.compile(r"(M\d{1,3})([A-Z$])(-?\d{1,6}(?:\.\d{1,3})?)")
_NAMED = re.compile(r"o<[a-z0-9_-]+>|#<[a-z0-9_-]+>(?:=-?[0-9.]+)?")
#: M words of a controller that start and stop a tool or coolant, which a table may wire otherwise.
_WIRED_M = frozenset((3, 4, 5, 7, 8, 9))
_OF_TABLES = frozenset(get_args(TableMeaning))
#: M words that switch outputs, and the letter that says which.
_OUTPUTS = {
    **dict.fromkeys(("M10", "M11", "M62", "M63", "M64", "M65"), "P"), "M67": "E", "M68": "E",
}  # fmt: skip
#: Meanings that need a number with the word.
CARRYING = {"feed share": "E P Q", "height": "P Q", "material": "P Q"}
#: "User Defined Commands M100-M199", and M words of its own that beamcam gives no meaning.
_OWN_OF_LINUXCNC = frozenset({*range(100, 200), *range(61, 74)})
#: Letters that a table of X and Y may carry for axes and offsets that beamcam does not follow.
OTHER_LETTERS = frozenset("ABCUVWZHTKELD")


def plain_code(text: str) -> str | None:
    """A G or M word without leading zeros, `G01` as `G1`; None if it is none."""
    match = _CODE.fullmatch(text)
    if match is None or (match[1] == "M" and match[3]):
        return None
    return f"{match[1]}{int(match[2])}{match[3] or ''}"


def plain_key(text: str) -> str:
    """A key of `[codes]` as programs are looked at: `M064P02` as `M64P2`, any other as it is."""
    match = _CARRYING.fullmatch(text)
    if match is not None:
        return f"{plain_code(match[1])}{match[2]}{float(match[3]):g}"
    return plain_code(text) or text


def meaning_of(
    codes: Mapping[str, CodeMeaning], code: str, values: Mapping[str, float]
) -> tuple[str, CodeMeaning] | None:
    """The key that explains a word with what it carries, and what it says; None if there is none.

    A key with what the word carries goes before one of the word alone.
    """
    for letter, value in values.items():
        key = f"{code}{letter}{value:g}"
        if key in codes:
            return key, codes[key]
    return (code, codes[code]) if code in codes else None


def key_for(code: str, values: Mapping[str, float]) -> str:
    """The key that would explain a word: with the number of its output, where it is one's."""
    letter = _OUTPUTS.get(code, "")
    return f"{code}{letter}{values[letter]:g}" if values.get(letter, -1.0) >= 0.0 else code


def shown_code(code: str) -> str:
    """A plain word as programs have it, `G1` as `G01`."""
    return f"{code[0]}0{code[1:]}" if len(code.partition(".")[0]) == 2 else code


def code_faults(machine: Machine) -> Iterator[CodeFault]:
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
    yield from _allowed_faults(machine)


def _table_code_faults(machine: Machine, code: str, meaning: CodeMeaning) -> Iterator[CodeFault]:
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
    carrying = _CARRYING.fullmatch(code)
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


def _allowed_faults(machine: Machine) -> Iterator[CodeFault]:
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
