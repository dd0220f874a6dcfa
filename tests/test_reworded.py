"""Messages are for people: whatever they say, the same is decided."""

import ast
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from beamcam import errors
from beamcam.errors import Diagnostic, Rule, Source
from tests.conftest import ROOT
from tests.runs import call

SUFFIXES = (".nc1", ".dxf", ".svg", ".json", ".ifc")
SAMPLES = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / "samples").rglob("*.*")
    if path.suffix in SUFFIXES
)
#: With what is asked of the read-back besides: a bar of unknown length, texts that are moved,
#: corners that a round beam does not reach, strokes that are shared, parts that are turned.
ASKED = (
    *((path, ()) for path in SAMPLES),
    *((path, more) for path in SAMPLES if path.count("/") == 2 for more in {
        ".nc1": (("--turn",), ("--machine", "beamline-pusher", "--allow-skips", "all")),
        ".dxf": (("--thickness", "3"), ("--machine", "laser-grbl")),
        ".svg": (("--thickness", "3"), ("--machine", "laser-grbl")),
        ".ifc": (("--force", "--allow-skips", "all"),),
    }.get(path[-4:], ())),
)  # fmt: skip
WRONG = ("saw = ['G00 X{x}', 'M2.5']", "footer = ['M90']", "drill = ['G00 X{x}']")


def reworded(self: Rule, source: Source, **values: object) -> Diagnostic:
    """What `Rule.at` gives, in other words: the values alone, in another order."""
    said = SAID(self, source, **values)
    text = " / ".join(f"{value}" for _, value in reversed(said.values))
    return Diagnostic(source, said.severity, said.code, f"({text})", said.values)


SAID = errors.Rule.at


def outcome(*words: str) -> tuple[object, ...]:
    """Exit status, and of each stream the program or the messages without their texts."""
    done = call(*words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, without_texts(done.stdout), without_texts(done.stderr)


def without_texts(stream: str) -> object:
    if not stream.startswith("["):
        return stream
    keys = ("file", "line", "where", "severity", "code")
    return [tuple(one[key] for key in keys) for one in json.loads(stream)]


def codes_in(streams: Iterable[object]) -> Iterator[str]:
    for stream in streams:
        if not isinstance(stream, str):
            yield from (code for *_, code in stream)  # type: ignore[attr-defined]


def of_all(folder: Path, every: int) -> Iterator[tuple[Any, ...]]:
    """What becomes of each sample, posted and read back."""
    for number, (path, more) in enumerate(ASKED[::every]):
        program = folder / f"{number}.program"
        posted = outcome("post", path, *more, "-o", str(program), "--json")
        yield path, more, posted
        if posted[0] == 0:
            yield path, more, program.read_bytes()
            yield path, more, outcome("verify", str(program), "--against", path, "--json")
        program.unlink(missing_ok=True)


@pytest.mark.parametrize("every", [74, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_other_words_decide_nothing_else(
    every: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    before = list(of_all(tmp_path, every))
    said = [made for _, _, made in before if isinstance(made, tuple)]
    seen = {code for _, *streams in said for code in codes_in(streams)}
    assert every > 1 or seen >= {"plan-text-moved", "plan-left-in-corner", "plan-turned"}
    monkeypatch.setattr(Rule, "at", reworded)
    done = call("post", "samples/bad/slot.nc1", "-o", "-")
    assert "found" not in done.stderr
    for old, new in zip(before, of_all(tmp_path, every), strict=True):
        assert old == new


@pytest.mark.parametrize("words", WRONG)
def test_a_machine_of_wrong_words(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "beamline"\n[words]\n{words}\n')
    asked = ("post", str(ROOT / "samples/dstv/beam.nc1"), "--machine", str(path), "-o", "-",
             "--json")  # fmt: skip
    old = outcome(*asked)
    assert old[0] == 1
    monkeypatch.setattr(Rule, "at", reworded)
    assert outcome(*asked) == old


TAKE_APART = {"split", "partition", "rpartition", "removeprefix", "removesuffix", "startswith",
              "endswith", "find", "index", "replace", "findall", "finditer", "search", "match",
              "fullmatch"}  # fmt: skip


def taken_apart(tree: ast.AST) -> Iterator[int]:
    """The lines at which a message is looked into."""
    for node in ast.walk(tree):
        inner: list[ast.expr] = []
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            inner = [node.func.value, *node.args] if node.func.attr in TAKE_APART else []
        elif isinstance(node, ast.Compare):
            inner = [node.left, *node.comparators]
        if any(isinstance(one, ast.Attribute) and one.attr == "message" for one in inner):
            yield node.lineno  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    "code", ["d.message.partition(';')", "PATTERN.findall(d.message)", "'at x' in d.message"]
)
def test_what_takes_a_message_apart_is_seen(code: str) -> None:
    assert list(taken_apart(ast.parse(code))) == [1]


def test_no_message_is_taken_apart() -> None:
    found = {
        f"{path.relative_to(ROOT)}:{line}"
        for path in (ROOT / "beamcam").rglob("*.py")
        if ".message" in (text := path.read_text(encoding="utf-8"))
        for line in taken_apart(ast.parse(text))
    }
    assert not found
