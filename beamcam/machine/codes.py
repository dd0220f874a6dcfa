"""G and M words: those that a machine's file gives a meaning, and all that its controller takes."""

import re
from collections.abc import Iterator
from typing import Literal

from beamcam.machine.machine import Machine

CodeFault = tuple[str, object, str]  #: dotted key, what was found, what was expected

#: G words with a fixed meaning on every controller of a family, whatever a file says.
_DOCUMENTED_G = frozenset(range(7)) | {8, 9, 17, 20, 21, 40, 41, 42, 64, 75, 90, 91, 98, 99}
_DOCUMENTED_M = frozenset(range(10)) | {30}
_CODE = re.compile(r"([GM])(\d{1,3})(\.\d)?")
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


def shown_code(code: str) -> str:
    """A plain word as programs have it, `G1` as `G01`."""
    return f"{code[0]}0{code[1:]}" if len(code.partition(".")[0]) == 2 else code


def code_faults(machine: Machine) -> Iterator[CodeFault]:
    """Words of `[codes]` and `allowed_codes` that are none, or cannot mean what they should."""
    for code, meaning in machine.codes.items():
        key = f"codes.{code}"
        if code in OTHER_LETTERS and machine.stock == "sheet" and meaning == "none":
            continue
        plain = plain_code(code)
        if plain is None:
            yield key, code, "a G word such as G81, or an M word such as M77"
        elif _number(plain) in (_DOCUMENTED_G if plain[0] == "G" else _DOCUMENTED_M):
            yield key, code, "another word, as the controller gives that one a meaning"
        elif meaning != "none" and plain[0] == "M":
            yield key, meaning, "none, as an M word switches what only a template can tell"
        elif meaning != "none" and machine.stock == "sheet":
            yield key, meaning, "none, a table does not drill"
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
    if machine.startup_code and machine.controller not in ("linuxcnc", "grbl"):
        expected = f"none, programs of {machine.controller} say all that holds"
        yield "startup_code", machine.startup_code, expected
    yield from _allowed_faults(machine)


def _allowed_faults(machine: Machine) -> Iterator[CodeFault]:
    worded: tuple[Literal["codesys"], ...] | tuple[str, ...] = ("codesys", "linuxcnc", "grbl")
    if machine.allowed_codes and machine.controller not in worded:
        found = list(machine.allowed_codes)
        yield "allowed_codes", found, f"none, a program of {machine.controller} has no such words"
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
    return machine.controller == "codesys"
