"""Every word and event that an interpreter knows has a row: what refuses it, or why it is harmless.

The words come from the interpreters, the events from their module; `OWNERS` of the rooms has to
hold the same, each once.
"""

import json
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import get_args

import pytest
from msgspec.structs import replace

from beamcam.checks import Language, Owner, Rows, Stock
from beamcam.commands import codes
from beamcam.controllers import events, interpreter_of
from beamcam.machine import Machine, load
from tests.conftest import ROOT, SAMPLES
from tests.linuxcnc_cell import linuxcnc_cell
from tests.owners import Vocabulary, unknown, unowned
from tests.runs import call
from tests.unit.controllers.test_cycles import CODESYS, LINUXCNC

OWNERS: Rows = codes.all_owners()
STOCKS: tuple[Stock, ...] = tuple(dict.fromkeys(stock for stock, _ in OWNERS))


def vocabulary(machines: list[Machine]) -> dict[str, frozenset[str]]:
    found: dict[str, frozenset[str]] = {}
    for machine in machines:
        for word, letters in interpreter_of(machine, "").vocabulary().items():
            found[word] = found.get(word, frozenset()) | letters
    return found


def with_all_placeholders(machine: Machine) -> Machine:
    """The machine with a choice and a change of tools that say all that such words may carry."""
    choice, change, coolant = {
        "codesys": (
            "M45 K{spindle} L{diameter} H{station} R{pitch} T{tool}", "M06 H{station} T{tool}",
            "M07",
        ),
        "linuxcnc": ("M145 P{pitch} Q{station}", "M106 P{station} Q{tool}", "M7"),
    }[machine.controller]  # fmt: skip
    more = ("M145 P{spindle} Q{tool}", "M4 S{speed}") if machine.controller == "linuxcnc" else ()
    drill = (choice, *more, *machine.words.drill, coolant)
    return replace(machine, words=replace(machine.words, drill=drill, change=(change,)))


def vocabularies(folder: Path) -> Iterator[tuple[Stock, Language, Vocabulary]]:
    """All words of every controller, by machines that between them have each role and meaning."""
    own = {"codesys": CODESYS, "linuxcnc": LINUXCNC}
    files = {name: folder / f"{name}.toml" for name in own}
    for name, path in files.items():
        path.write_text(own[name])
    samples = [load(str(path)) for path in sorted((SAMPLES / "machines").glob("*.toml"))]
    shipped = [load(path.stem) for path in (ROOT / "beamcam" / "machines").glob("*.toml")]
    machines = [*shipped, *samples, linuxcnc_cell(), *(load(str(path)) for path in files.values())]
    machines += map(with_all_placeholders, (load("beamline-pusher"), linuxcnc_cell()))
    for stock, language in OWNERS:
        if language == "events":
            kinds = (events.Move, *get_args(events.Other))
            fields = [
                f"{kind.__name__}.{name}" for kind in kinds for name in kind.__struct_fields__
            ]
            yield stock, language, {f: frozenset() for f in fields if not f.endswith(".line")}
        else:
            like = [m for m in machines if m.stock == stock and m.controller == language]
            assert like, f"no machine of {stock} and {language}"
            yield stock, language, vocabulary(like)


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Stock, Language, Vocabulary]]:
    return list(vocabularies(tmp_path_factory.mktemp("machines")))


def test_every_word_of_an_interpreter_has_one_row(
    known: list[tuple[Stock, Language, Vocabulary]],
) -> None:
    found = {(stock, of): unowned(words, OWNERS[stock, of]) for stock, of, words in known}
    assert not any(found.values()), found


@pytest.mark.parametrize("stock", STOCKS)
def test_every_row_is_that_of_a_word(
    stock: Stock, known: list[tuple[Stock, Language, Vocabulary]]
) -> None:
    words = [vocabulary for one, _, vocabulary in known if one == stock]
    assert not unknown(
        words, [row for key, rows in OWNERS.items() if key[0] == stock for row in rows]
    )


def test_bars_are_owned_on_every_controller_that_runs_them() -> None:
    assert {language for stock, language in OWNERS if stock == "beam"} == {
        "codesys", "linuxcnc", "events",
    }  # fmt: skip


def test_sheets_are_owned_on_every_controller_of_g_code() -> None:
    assert {language for stock, language in OWNERS if stock == "sheet"} == {
        "codesys", "linuxcnc", "grbl", "mach3", "events",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"G1": frozenset("X"), "G5": frozenset()}, ("G5",)),
        ({"G1": frozenset("XQ")}, ("G1 Q",)),
        ({"G1": frozenset("X")}, ()),
    ],
)
def test_a_word_without_an_owner_fails(words: Vocabulary, said: tuple[str, ...]) -> None:
    rows = (Owner(("G1",), (), ("verify-word",)), Owner(("G1",), ("X",), ("verify-word",)))
    assert unowned(words, rows) == said
    assert unowned(words, (*rows, rows[0])) == tuple(sorted({"G1", *said}))
    assert unknown([words], (*rows, Owner(("G9",), ("Z",)))) == ("G9 Z",)


def test_every_row_is_refused_by_a_code_that_there_is_or_says_why_not() -> None:
    known = {rule.code for rule in codes.all_rules()}
    for rows in OWNERS.values():
        for row in rows:
            assert row.refused_by or row.harmless, row.words
            for pattern in row.refused_by:
                assert any(fnmatchcase(code, pattern) for code in known), pattern


def test_the_page_of_the_documentation_lists_the_rows() -> None:
    done = call("codes", "--words", "--markdown", status=0)
    assert (ROOT / "docs" / "words.md").read_text(encoding="utf-8") == done.output


def test_the_rows_are_printed_and_given_as_data() -> None:
    plain = call("codes", "--words")
    assert "beam, codesys\n" in plain.output
    assert "G75  harmless: " in plain.output
    data = call("codes", "--words", "--json")
    assert ["G41", "G42"] in [row["words"] for row in json.loads(data.output)]
