"""Files damaged in one place or several: bytes, numbers, words, lines, brackets of any format."""

import gzip
import io
import random
import re
import zipfile
from collections.abc import Callable

_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")
_NAME = re.compile(rb"#[0-9A-Za-z_-]+|\"[^\"\n]*\"|'[^'\n]*'")
_VALUE = re.compile(rb"\"[^\"\n]*\"|\btrue\b|\bfalse\b|[-+]?\d+\.?\d*")
_TEXT = re.compile(rb"\"[^\"\n]*\"|'[^'\n]*'")

#: Numbers that break arithmetic, loops and memory where nobody looks at them.
NUMBERS = (
    b"0", b"-0.0", b"-1", b"1", b"2", b"7", b"0.001", b"1e-12", b"1e-300", b"5e-324", b"1e9",
    b"-1e9", b"1e15", b"1e300", b"1e308", b"-1e308", b"1e400", b"nan", b"inf", b"-inf",
    b"999999999", b"2147483648", b"-2147483649", b"18446744073709551616", b"9" * 400, b"9" * 5000,
    b"0x10", b"1.2.3", b"360", b"-360", b"359.9999999999", b"90", b"45", b"1_000", b"1,5", b"",
)  # fmt: skip
#: Text that steers terminals and programs, ends comments, or is no text.
TEXTS = (
    b"\x1b[2J", b"\xe2\x80\xae", b"\xe2\x80\xa8", b"\xc2\x85", b"\x0b", b"\0", b"\r", b"\n",
    b"(MSG,x)", b")", b"(", b"%", b";", b"*)", b"*/", b"\xff\xfe", b"\xed\xa0\x80", b"\\ud800",
    b"&#0;", b"<!--", b"]]>", b"'", b'"', b"\\", b"../../x", b"A" * 3000, b"{x:>999999999}",
    b"{0.__class__}", b"\xc3\x9f",
)  # fmt: skip
#: Values of other kinds than one that is there.
OTHERS = (
    b"null",
    b"true",
    b"[]",
    b"{}",
    b"[[1, 2]]",
    b'"x"',
    b"$",
    b"*",
    b"()",
    b".T.",
    b"5",
    b"-",
)
#: How a whole file may be written by another system.
ENCODINGS = ("utf-16", "utf-16-be", "utf-8-sig", "cp037")
DEEP = 3000  #: brackets inside one another
MANY = 200  #: times that a line is said again

Damage = Callable[[bytes, random.Random], bytes]


def _place(data: bytes, chance: random.Random) -> int:
    return chance.randrange(len(data) + 1)


def flip_byte(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    return data[:at] + bytes([chance.randrange(256)]) + data[at + 1 :]


def drop_stretch(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    return data[:at] + data[at + chance.choice((1, 2, 8, 64, 512)) :]


def repeat_stretch(data: bytes, chance: random.Random) -> bytes:
    at, length = _place(data, chance), chance.choice((1, 8, 64, 512))
    return data[:at] + data[at : at + length] * chance.choice((2, 3, MANY)) + data[at:]


def cut_short(data: bytes, chance: random.Random) -> bytes:
    return data[: _place(data, chance)]


def change_number(data: bytes, chance: random.Random) -> bytes:
    return _replaced(_NUMBER, data, chance, chance.choice(NUMBERS))


def scale_number(data: bytes, chance: random.Random) -> bytes:
    """Another number of the same order, which most checks let pass."""
    by = chance.choice((-1.0, 0.0, 0.5, 0.999, 1.001, 2.0, 10.0, 1000.0))
    return _computed(data, chance, lambda value: value * by)


def nudge_number(data: bytes, chance: random.Random) -> bytes:
    """A number that differs a little, so that what met meets no more, or nearly."""
    step = chance.choice((-1.0, 1.0)) * 10.0 ** -chance.randrange(10)
    return _computed(data, chance, lambda value: value + step)


def round_number(data: bytes, chance: random.Random) -> bytes:
    """A number with fewer digits, so that what was apart may meet."""
    return _computed(data, chance, lambda value: round(value, chance.choice((-2, -1, 0, 1, 2, 3))))


def exchange_names(data: bytes, chance: random.Random) -> bytes:
    """A record or an element that refers to another one, perhaps to itself."""
    return _replaced(_NAME, data, chance, _one_of(_NAME, data, chance))


def change_kind(data: bytes, chance: random.Random) -> bytes:
    return _replaced(_VALUE, data, chance, chance.choice(OTHERS))


def write_otherwise(data: bytes, chance: random.Random) -> bytes:
    """The file in another encoding, with other line ends, or packed."""
    way = chance.randrange(len(ENCODINGS) + 4)
    if way < len(ENCODINGS):
        return data.decode("latin-1").encode(ENCODINGS[way], "replace")
    if way < len(ENCODINGS) + 2:
        return b"\n".join(data.splitlines()).replace(b"\n", (b"\r", b"\r\n")[way % 2])
    if way == len(ENCODINGS) + 2:
        return gzip.compress(data, mtime=0)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(zipfile.ZipInfo("model.ifc"), data)
    return packed.getvalue()


def move_lines(data: bytes, chance: random.Random) -> bytes:
    """Some lines, at another place as well."""
    lines = data.splitlines(keepends=True)
    start, to = chance.randrange(len(lines) + 1), chance.randrange(len(lines) + 1)
    some = lines[start : start + chance.choice((1, 3, 10))]
    return b"".join([*lines[:to], *some, *lines[to:]])


def exchange_numbers(data: bytes, chance: random.Random) -> bytes:
    return _replaced(_NUMBER, data, chance, _one_of(_NUMBER, data, chance))


def exchange_words(data: bytes, chance: random.Random) -> bytes:
    return _replaced(_WORD, data, chance, _one_of(_WORD, data, chance))


def change_text(data: bytes, chance: random.Random) -> bytes:
    return _replaced(_TEXT, data, chance, b'"' + chance.choice(TEXTS) + b'"')


def insert_text(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    return data[:at] + chance.choice(TEXTS) + data[at:]


def drop_line(data: bytes, chance: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if lines:
        del lines[chance.randrange(len(lines))]
    return b"".join(lines)


def repeat_line(data: bytes, chance: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    at = chance.randrange(len(lines))
    return b"".join([*lines[:at], lines[at] * chance.choice((2, 3, MANY)), *lines[at:]])


def exchange_lines(data: bytes, chance: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if lines:
        a, b = chance.randrange(len(lines)), chance.randrange(len(lines))
        lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def nest(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    opening, closing = chance.choice(((b"[", b"]"), (b"(", b")"), (b"{", b"}"), (b"<g>", b"</g>")))
    depth = chance.choice((2, 50, DEEP))
    return data[:at] + opening * depth + closing * chance.choice((depth, 0)) + data[at:]


DAMAGES: tuple[Damage, ...] = (
    flip_byte, drop_stretch, repeat_stretch, cut_short, change_number, change_number, scale_number,
    scale_number, scale_number, exchange_numbers, exchange_numbers, exchange_words, change_text,
    insert_text, drop_line, repeat_line, exchange_lines, nest, nudge_number, nudge_number,
    nudge_number, nudge_number, round_number, round_number, exchange_names, change_kind,
    write_otherwise, move_lines,
)  # fmt: skip


def damaged(data: bytes, chance: random.Random) -> bytes:
    """`data` with one fault, or a few: the more, the sooner a reader stops at the first."""
    for _ in range(chance.choice((1, 1, 1, 1, 2, 2, 3, 6))):
        data = chance.choice(DAMAGES)(data, chance)
    return data


def _computed(data: bytes, chance: random.Random, change: Callable[[float], float]) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    match = chance.choice(found)
    try:
        value = change(float(match[0]))
    except OverflowError:  # of rounding
        return data
    return data[: match.start()] + f"{value:.12g}".encode() + data[match.end() :]


def _one_of(pattern: re.Pattern[bytes], data: bytes, chance: random.Random) -> bytes:
    found = pattern.findall(data)
    return bytes(chance.choice(found)) if found else b""


def _replaced(
    pattern: re.Pattern[bytes], data: bytes, chance: random.Random, other: bytes
) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return data
    match = chance.choice(found)
    return data[: match.start()] + other + data[match.end() :]
