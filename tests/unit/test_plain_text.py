"""Text from outside: harmless in programs and on terminals, whatever it holds."""

import ast
import json
import re
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.plain_text import (
    MAX_COMMENT,
    comment_text,
    json_text,
    one_word,
    terminal_lines,
    terminal_text,
)

PACKAGE = Path(__file__).resolve().parents[2] / "beamcam"
ANY = st.text(st.characters(), max_size=60)  # halves of surrogate pairs too


@given(ANY)
def test_a_comment_is_plain_whatever_it_is_made_of(text: str) -> None:
    plain = comment_text(text)
    assert re.fullmatch(r"[A-Za-z0-9 .,:+\-_=/]*", plain)
    squeezed = plain.replace(" ", "").upper()
    assert not squeezed.startswith(("MSG", "DEBUG", "PRINT", "LOG", "PROBE", "ABORT", "PY"))
    assert comment_text(plain) == plain


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("M58-a, part 2/3", "M58-a, part 2/3"),
        ("Träger Ø12", "Trager _12"),
        ("a)\nG00 X0", "a__G00 X0"),
        ("a\u2028b\x85c\x0bd\x0ce\rf", "a_b_c_d_e_f"),
        ("100% [x] {y} ; z *) */", "100_ _x_ _y_ _ z __ _/"),
        ("MSG, hello", "_MSG, hello"),
        ("  m s g,hello", "_m s g,hello"),
        ("Print1", "_Print1"),
        ("dialogue", "dialogue"),
        ("'$\"?!~#&", "________"),
        ("x" * 300, "x" * MAX_COMMENT),
    ],
)
def test_comments(text: str, plain: str) -> None:
    assert comment_text(text) == plain


@given(ANY)
def test_a_word_is_one_word(text: str) -> None:
    assert re.fullmatch(r"[A-Za-z0-9._-]+", one_word(text))


@given(ANY)
def test_a_terminal_gets_nothing_to_obey(text: str) -> None:
    shown = terminal_text(text)
    kinds = {unicodedata.category(sign) for sign in shown}
    assert not kinds & {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}
    assert len(shown.splitlines()) <= 1
    shown.encode("utf-8")
    assert terminal_text(shown) == shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[2J", "\\x1b[2J"),
        ("\x9b2J", "\\x9b2J"),
        ("\u202eabc\u2066", "\\u202eabc\\u2066"),
        ("a\tb\r\n\x85\u2028", "a\\tb\\r\\n\\x85\\u2028"),
        ("1\xa0mm\u2009wide", "1 mm wide"),
        ("Träger 梁 é", "Träger 梁 é"),
        ("\ud800\U000e0001", "\\ud800\\U000e0001"),
    ],
)
def test_terminals(text: str, shown: str) -> None:
    assert terminal_text(text) == shown


def test_lines_keep_their_ends() -> None:
    assert terminal_lines("a\x1b\nb\u2028c\n") == "a\\x1b\nb\\u2028c\n"


@given(st.recursive(ANY, lambda inner: st.lists(inner) | st.dictionaries(ANY, inner)))
def test_json_means_the_same(value: object) -> None:
    text = json_text(json.dumps(value, ensure_ascii=False, indent=1))
    assert json.loads(text) == value
    assert all(line.isprintable() for line in text.split("\n"))
    text.encode("utf-8")


#: Modules that print what is no line for people: programs, tables, scripts of shells, and the bars
#: that a terminal draws over.
PRINTERS = {"common.py", "running.py", "completion.py", "codes.py", "machines.py", "options.py"}


def test_every_command_prints_through_the_gate() -> None:
    for path in sorted((PACKAGE / "commands").glob("*.py")):
        calls = [
            node
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call)
            and ast.unparse(node.func) in ("click.echo", "print", "click.secho")
        ]
        assert not calls or path.name in PRINTERS, path.name


def test_every_emitter_writes_text_through_the_gate() -> None:
    """`job`, `text` and `remark` are the words of a program that a file or a user says."""
    for path in sorted((PACKAGE / "emitters").glob("*.py")):
        source = path.read_text(encoding="utf-8")
        for match in re.finditer(r"\{(?:remark|job|text)\}|\b(?:table|_program)\.job\b", source):
            before = source[max(0, match.start() - 20) : match.start()]
            assert before.endswith(("outside_text(self.", "one_word(", "unit_name(")), (path, match)
