"""Text from outside (marks, layers, jobs, names of files) before it reaches a program or a screen.

All text that was not written by beamcam goes through one of these: `outside_text` on its way into
a program (`comment_text` where it stands within another text), `terminal_text` on its way to a
terminal, `one_word` where a program needs a name without blanks. They replace what is odd, so that
an odd mark refuses no part.
"""

import re

#: Characters accepted in comments by all controllers, in G-code, Structured Text and C. Excluded:
#: line ends and all other controls; brackets and `*`, which end comments or begin variables; `%`
#: and `;`, which end programs and begin comments; quotes and `$` of Structured Text; `?`, `!` and
#: `~`, which GRBL obeys anywhere; `#` and `&`, for which there is no need.
_NOT_IN_COMMENTS = re.compile(r"[^A-Za-z0-9 .,:+\-_=/]")
REPLACEMENT = "_"

#: A comment that begins with one of these is a command to LinuxCNC, in any case and with blanks
#: between the letters. Source: LinuxCNC, G-code overview, "Messages", "Probe Logging", "Logging",
#: "Debug Messages", "Print Messages"; rs274ngc, convert_comment; for ABORT and PY its remaps.
_ACTIVE_WORDS = ("MSG", "DEBUG", "PRINT", "LOG", "PROBE", "ABORT", "PY")
_ACTIVE = re.compile("|".join(" *".join(word) for word in _ACTIVE_WORDS), re.IGNORECASE)

#: How a head begins, and what an operator is told at a stop: `BEAMCAM 2`, `web station 3: mill 16`.
_LIKE_HEAD = re.compile(r"(?<=BEAMCAM) (?= *[0-9])")
_LIKE_STOP = re.compile(r"(station +[0-9]+ *):", re.IGNORECASE)

#: rs274 refuses lines of 256 characters and more; a template may put words around a text.
MAX_COMMENT = 200

_NUMBERS = re.compile(r"[+-]?[0-9]+(?:\.[0-9]+)?(?:;? [+-]?[0-9]+(?:\.[0-9]+)?)*")
_NOT_IN_WORDS = re.compile(r"[^A-Za-z0-9._-]+")
_SHORT_SIGNS = {"\t": "\\t", "\n": "\\n", "\r": "\\r"}


def comment_text(text: str) -> str:
    """`text` as a comment of any program may hold it: plain ASCII that no controller obeys.

    Letters with accents lose them, any other odd character becomes `_`.
    """
    if not text.isascii():
        from unicodedata import combining, normalize

        text = "".join(sign for sign in normalize("NFKD", text) if not combining(sign))
    plain = _NOT_IN_COMMENTS.sub(REPLACEMENT, text)[:MAX_COMMENT]
    return REPLACEMENT + plain.lstrip() if _ACTIVE.match(plain.lstrip()) else plain


def outside_text(text: str) -> str:
    """As `comment_text`, of a mark or a job's name: nothing that programs tell by comments.

    A mark may be `BEAMCAM 2 MACHINE x` or `web station 3: mill 16`, and would be taken for the head
    of the program, or for what an operator is told at a stop.
    """
    plain = comment_text(text)
    if "BEAMCAM" in plain:
        plain = _LIKE_HEAD.sub(REPLACEMENT, plain)
    return _LIKE_STOP.sub(r"\1.", plain) if "station" in plain.lower() else plain


def whole_text(text: str) -> str:
    """`text` with U+FFFD for each half of a character, which no file takes."""
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")
    return text


def one_word(text: str) -> str:
    """`text` as a word: ASCII letters, digits, `.`, `_` and `-`, any run of others as one `_`."""
    return _NOT_IN_WORDS.sub(REPLACEMENT, text)[:MAX_COMMENT] or REPLACEMENT


def terminal_text(text: str) -> str:
    """`text` as one line for people, without anything that a terminal obeys.

    Controls, escapes, line ends of all kinds, characters that turn the direction of writing, and
    halves of characters are spelled out (`\\x1b`, `\\u202e`); a blank of any width is a blank.
    """
    return text if text.isprintable() else "".join(map(_spelled, text))


def terminal_lines(text: str) -> str:
    """`text` of several lines, its own line ends kept and each line as `terminal_text` gives it."""
    if text.isprintable():
        return text
    return "\n".join(terminal_text(line) for line in text.split("\n"))


def json_text(text: str) -> str:
    """JSON with the characters spelled out as `\\uXXXX` that `terminal_text` would spell out.

    It means the same to all readers, and line ends between its values stay.
    """
    return "\n".join(
        line if line.isprintable() else "".join(map(_escaped, line)) for line in text.split("\n")
    )


def fault_text(error: Exception) -> str:
    """What a parser of Python found, without words that are about Python."""
    if isinstance(error, RecursionError):
        return "values too deep inside one another"
    if str(error).startswith("Exceeds the limit"):  # of digits of a whole number
        return "a number of more digits than any has"
    return str(error) or type(error).__name__


def harmless_cell(cell: object) -> object:
    """A text as one line, with a quote before what a spreadsheet would take for a formula.

    A number, and several as of a path, stay what they are.
    """
    if not isinstance(cell, str):
        return cell
    text = terminal_text(cell)
    is_formula = text.startswith(("=", "+", "-", "@")) and not _NUMBERS.fullmatch(text)
    return f"'{text}" if is_formula else text


def _spelled(sign: str) -> str:
    if sign.isprintable():
        return sign
    if (sign.isspace() and ord(sign) > 0xFF and sign not in "\u2028\u2029") or sign == "\xa0":
        return " "
    code = ord(sign)
    short = f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
    return _SHORT_SIGNS.get(sign, short if code < 0x10000 else f"\\U{code:08x}")


def _escaped(sign: str) -> str:
    if sign.isprintable():
        return sign
    units = sign.encode("utf-16-be", "surrogatepass")
    pairs = (units[k : k + 2] for k in range(0, len(units), 2))
    return "".join(f"\\u{int.from_bytes(pair):04x}" for pair in pairs)
