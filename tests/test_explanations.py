"""`beamcam codes CODE`: examples are messages of samples, what to do is docs/refused.md's.

`pytest tests/test_explanations.py --update-golden` writes beamcam/commands/explanations.json.
"""

import re
from pathlib import Path

import msgspec
import pytest

from beamcam.commands import codes
from tests.conftest import ROOT, Golden
from tests.runs import call

FILE = Path(codes.__file__).with_name("explanations.json")
SUFFIXES = (".nc1", ".dxf", ".svg", ".json", ".ifc")
MESSAGE = re.compile(r"^samples/\S+: (?:error|warning|note) ([a-z0-9-]+): .+", re.MULTILINE)
ROW = re.compile(r"^\| (`.+?`) \| (.+) \|$", re.MULTILINE)


def of_samples(monkeypatch: pytest.MonkeyPatch, every: bool) -> dict[str, str]:
    """The first message of each code that posting the samples gives, in their order; of every
    sample, or of each twelfth that an example is of beside the examples of others."""
    monkeypatch.chdir(ROOT)
    known = msgspec.json.decode(FILE.read_bytes(), type=dict[str, codes.CodeExplanation])
    paths = sorted(p for p in Path("samples").rglob("*.*") if p.suffix in SUFFIXES)
    found: dict[str, str] = {}
    if not every:
        of = {code: row.example.partition(":")[0] for code, row in known.items() if row.example}
        paths = [p for p in paths if p.as_posix() in of.values()][::12]
        asked = {path.as_posix() for path in paths}
        found = {code: known[code].example for code, path in of.items() if path not in asked}
    for path in paths:
        done = call("post", path.as_posix(), "-o", "-")
        for message in MESSAGE.finditer(done.stderr):
            found.setdefault(message[1], message[0])
    return found


def of_the_page() -> dict[str, str]:
    """What the page says to do, by code, without its links."""
    page = (ROOT / "docs" / "refused.md").read_text(encoding="utf-8")
    return {
        code: re.sub(r"\[([^]]+)\]\([^)]*\)", r"\1", text)
        for names, text in ROW.findall(page)
        for code in re.findall("`([a-z0-9-]+)`", names)
    }


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.exhaustive)])
def test_explanations_are_those_of_samples_and_docs(
    every: bool, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    examples, ways = of_samples(monkeypatch, every or golden.update), of_the_page()
    known = {rule.code for rule in codes.all_rules()}
    found = {
        code: codes.CodeExplanation(examples.get(code, ""), ways.get(code, ""))
        for code in sorted({*examples, *ways} & known)
    }
    text = msgspec.json.format(msgspec.json.encode(found), indent=1).decode() + "\n"
    golden.check(FILE, text)


def test_one_code_is_shown_with_an_example_and_what_to_do() -> None:
    done = call("codes", "plan-cope", status=0)
    assert (
        "example\n    samples/coping/header.nc1:38: error plan-cope: found a contour" in done.output
    )
    assert "what to do\n    " in done.output
