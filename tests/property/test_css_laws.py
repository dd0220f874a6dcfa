"""What takes linear time finds what the plain patterns of the grammar find."""

import re

from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.svg.tree import (
    _rules,
    _without_comments,
    _without_statements,
    declarations,
)

sheets = st.lists(
    st.sampled_from(
        ["/*", "*/", "*", "/", "a", ".b", "{", "}", ";", "@import", "@charset", "@font", " ", "!",
         "important", "IMPORTANT", "<!--", "-->", ":", "\n", "red", "\t"]
    ),
    max_size=30,
).map("".join)  # fmt: skip


@given(sheets)
def test_comments(text: str) -> None:
    plain = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    assert _without_comments(text) == plain.replace("<!--", " ").replace("-->", " ")


@given(sheets)
def test_statements(text: str) -> None:
    assert _without_statements(text) == re.sub(r"@(?:import|charset|namespace)[^;{]*;", " ", text)


@given(sheets)
def test_rules(text: str) -> None:
    assert list(_rules(text)) == re.findall(r"([^{}]*)\{([^{}]*)\}", text)


@given(sheets)
def test_declarations(text: str) -> None:
    important = re.compile(r"\s*!\s*important\s*\Z", re.IGNORECASE)
    wanted = []
    for part in text.split(";"):
        name, colon, value = part.partition(":")
        if colon:
            plain = important.sub("", value)
            wanted.append((name.strip().lower(), plain.strip(), plain != value))
    assert list(declarations(text)) == wanted
