"""Messages: their form, and that every rule's placeholders are known to fill."""

import re
from string import Formatter

import pytest

from beamcam.commands.codes import all_rules
from beamcam.errors import BeamcamError, Diagnostic, Rule, Severity, Source, errors_in
from beamcam.reports.run import as_message, message_line

RULE = Rule("x-width", Severity.WARNING, "found {found}; expected {expected}", "Because.")


def test_a_message_is_one_line_whatever_a_name_holds() -> None:
    said = RULE.at(Source("a\n\x1b[2Jb ä\xa0\udcff.nc1", 37), found="x\ry\t", expected=4)
    assert str(said) == (
        "a\\n\\x1b[2Jb ä \\udcff.nc1:37: warning x-width: found x\\ry\\t; expected 4"
    )
    assert message_line(as_message(said)) == str(said)


def test_a_message_has_place_severity_code_and_text() -> None:
    said = RULE.at(Source("a.nc1", 37), found=3, expected="4 or 5")
    assert str(said) == "a.nc1:37: warning x-width: found 3; expected 4 or 5"


@pytest.mark.parametrize(
    ("source", "text"),
    [
        (Source("a.nc1"), "a.nc1"),
        (Source("a.nc1", 3), "a.nc1:3"),
        (Source("a.dxf", None, "#2F"), "a.dxf:#2F"),
        (Source("a.toml", 3, "saw.kerf"), "a.toml:3:saw.kerf"),
    ],
)
def test_sources(source: Source, text: str) -> None:
    assert str(source) == text


def test_a_missing_value_is_not_hidden() -> None:
    with pytest.raises(KeyError):
        RULE.at(Source("a"), found=3)


def test_an_error_carries_its_diagnostics() -> None:
    one = RULE.at(Source("a"), found=1, expected=2)
    assert BeamcamError(one).diagnostics == (one,)
    assert str(BeamcamError([one, one])) == f"{one}\n{one}"


def test_only_errors_refuse() -> None:
    said = [Diagnostic(Source("a"), s, "c", "m") for s in Severity]
    assert [d.severity for d in errors_in(said)] == [Severity.ERROR]


def test_codes_are_unique_and_explained() -> None:
    rules = list(all_rules())
    assert len(rules) > 40
    codes = [rule.code for rule in rules]
    assert len(codes) == len(set(codes))
    for rule in rules:
        assert rule.reason.endswith("."), rule.code
        assert rule.code == rule.code.lower()
        names = [n for _, n, _, _ in Formatter().parse(rule.message) if n]
        assert all(n.isidentifier() for n in names), rule.code


def test_every_error_says_what_was_expected() -> None:
    """The readers' promise, and that of all that comes behind them.

    `machine-word` passes on what the read-back of a template says, in its words.
    """
    without = {
        rule.code
        for rule in all_rules()
        if rule.severity is Severity.ERROR
        and not ("found" in rule.message and "expected" in re.sub(r"{.*?}", "", rule.message))
    }
    assert without == {"machine-word"}
