"""Ways to break a bar program in one place, and ways to rewrite it that change nothing.

A mutation gives None where there is nothing for it to break, whatever was done to the text before.
"""

import random
import re
from collections.abc import Callable, Sequence

FACES = {1: "o", 2: "v", 3: "u"}  #: of the cell's spindles
PAIR = 13

Mutate = Callable[[list[str], random.Random, float], list[str] | None]
_WORD = re.compile(r"([XYZKL])(-?\d+(?:\.\d+)?)")


def _blocks(lines: Sequence[str]) -> list[int]:
    return [i for i, line in enumerate(lines) if line.startswith("N")]


def picked(lines: Sequence[str], rng: random.Random, pattern: str) -> int | None:
    """Any of the lines that a pattern is found in; None if it is in none."""
    fitting = [i for i, line in enumerate(lines) if re.search(pattern, line)]
    return rng.choice(fitting) if fitting else None


def drop(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, "^N")
    return None if at is None else lines[:at] + lines[at + 1 :]


def double(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, "^N")
    return None if at is None else lines[: at + 1] + lines[at:]


def swap(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    blocks = _blocks(lines)
    if len(blocks) < 2:
        return None
    at = rng.choice(blocks[:-1])
    return [*lines[:at], lines[at + 1], lines[at], *lines[at + 2 :]]


def swap_far(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    blocks = _blocks(lines)
    if not blocks:
        return None
    a, b = rng.choice(blocks), rng.choice(blocks)
    result = list(lines)
    result[a], result[b] = result[b], result[a]
    return result


def _replace(lines: list[str], at: int, word: re.Match[str], new: str) -> list[str]:
    line = lines[at]
    return [*lines[:at], line[: word.start()] + new + line[word.end() :], *lines[at + 1 :]]


def _some_word(lines: list[str], rng: random.Random) -> tuple[int, re.Match[str]] | None:
    blocks = [i for i in _blocks(lines) if _WORD.search(lines[i])]
    if not blocks:
        return None
    at = rng.choice(blocks)
    return at, rng.choice(list(_WORD.finditer(lines[at])))


def flip_sign(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    found = _some_word(lines, rng)
    if found is None or float(found[1][2]) == 0:
        return None
    at, word = found
    digits = word[2][1:] if word[2].startswith("-") else f"-{word[2]}"
    return _replace(lines, at, word, word[1] + digits)


def change_digit(lines: list[str], rng: random.Random, step: float) -> list[str] | None:
    found = _some_word(lines, rng)
    if found is None:
        return None
    at, word = found
    places = [i for i, c in enumerate(word[2]) if c.isdigit()]
    place = rng.choice(places)
    digit = rng.choice([d for d in "0123456789" if d != word[2][place]])
    digits = word[2][:place] + digit + word[2][place + 1 :]
    if abs(float(digits) - float(word[2])) < 2 * step:
        return None  # within what the output can tell apart
    return _replace(lines, at, word, word[1] + digits)


def exchange_axes(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, r"X\S+ Y\S+ Z")
    if at is None:
        return None
    a, b = rng.sample("XYZ", 2)
    table = str.maketrans({a: b, b: a})
    return [*lines[:at], lines[at].translate(table), *lines[at + 1 :]]


def wrong_spindle(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, r"M40 K")
    if at is None:
        return None
    number = re.search(r"M40 K(\S*)", lines[at])
    other = rng.choice([str(n) for n in (*FACES, PAIR) if str(n) != number[1]])  # type: ignore[index]
    return [*lines[:at], re.sub(r"M40 K\S*", f"M40 K{other}", lines[at]), *lines[at + 1 :]]


def wrong_diameter(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, r"M40 K\d+ L")
    if at is None:
        return None
    old = float(re.search(r"L(\S+)", lines[at])[1])  # type: ignore[index]
    new = old + rng.choice((-4, -2, -1, 1, 2, 4, 0.75))
    return [*lines[:at], re.sub(r"L\S+", f"L{new:g}", lines[at]), *lines[at + 1 :]]


def negate_angle(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, r"M4[12] K-?[1-9]")
    if at is None:
        return None
    line = lines[at].replace("K-", "K", 1) if "K-" in lines[at] else lines[at].replace("K", "K-", 1)
    return [*lines[:at], line, *lines[at + 1 :]]


def drop_m_word(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, r" M\d+")
    return None if at is None else lines[:at] + lines[at + 1 :]


def other_m_word(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, r" M\d\d")
    if at is None:
        return None
    number = re.search(r" M(\d)(\d)", lines[at])
    digit = rng.choice([d for d in "0123456789" if d != number[2]])  # type: ignore[index]
    new = f" M{number[1]}{digit}"  # type: ignore[index]
    return [*lines[:at], re.sub(r" M\d\d", new, lines[at]), *lines[at + 1 :]]


def truncate(lines: list[str], rng: random.Random, _: float) -> list[str] | None:
    at = picked(lines, rng, "^N")
    return None if at is None else lines[:at]


MUTATIONS: tuple[Mutate, ...] = (
    drop, double, swap, swap_far, flip_sign, change_digit, change_digit, change_digit,
    exchange_axes, wrong_spindle, wrong_diameter, negate_angle, drop_m_word, other_m_word, truncate,
)  # fmt: skip


# Programs that only look different


def renumbered(text: str, rng: random.Random) -> str:
    step = rng.choice((1, 5, 10))
    counter = iter(range(step, 10**9, step))
    return re.sub(r"(?m)^N\d+", lambda _: f"N{next(counter)}", text)


def unnumbered(text: str, rng: random.Random) -> str:
    return re.sub(r"(?m)^N\d+ ", "", text)


def respaced(text: str, rng: random.Random) -> str:
    blank = rng.choice(("  ", "\t", " \t "))
    return "\n".join(f" {line.replace(' ', blank)} " for line in text.split("\n"))


def commented(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    if len(lines) < 5:
        return text
    for _ in range(5):
        lines.insert(rng.randrange(1, len(lines) - 2), "(checked by hand, X1 and M30)")
    at = rng.randrange(1, len(lines) - 3)
    lines[at] += " (M05)"
    return "\n".join(lines)


def leading_zeros(text: str, rng: random.Random) -> str:
    text = re.sub(r"([XYZ])(-?)(\d)", r"\1\g<2>00\3", text)
    return re.sub(r"\b([GM])(\d)", r"\g<1>0\2", text)


def trailing_zeros(text: str, rng: random.Random) -> str:
    return re.sub(r"(?<=[ ])([XYZ]-?\d+)(?=\s)", r"\1.000", text)


def short_commands(text: str, rng: random.Random) -> str:
    return re.sub(r"\b([GM])0(\d)", r"\1\2", text)


def lower_case(text: str, rng: random.Random) -> str:
    first, _, rest = text.partition("\n")
    return first + "\n" + rest.lower()


def other_line_ends(text: str, rng: random.Random) -> str:
    return text.replace("\n", "\r\n")


def blank_lines(text: str, rng: random.Random) -> str:
    return text.replace("\nN", "\n\nN")


def other_name(text: str, rng: random.Random) -> str:
    return re.sub(r"% \w+", "% ANOTHER", text)


REWRITES: tuple[Callable[[str, random.Random], str], ...] = (
    renumbered, unnumbered, respaced, commented, leading_zeros, trailing_zeros, short_commands,
    lower_case, other_line_ends, blank_lines, other_name,
)  # fmt: skip
