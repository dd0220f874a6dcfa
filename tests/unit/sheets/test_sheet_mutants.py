"""Every fault of some kinds in the programs of tables is found, on all machines that run G-code."""

import re
from collections.abc import Iterator
from itertools import islice, pairwise

import pytest

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.pipeline import post
from benchmarks.sheet_liars import MACHINES as LIARS
from benchmarks.sheet_liars import told

from .parts import NESTED, table

PLAIN = {"kerf_by": "none", "lead": "none"}
MACHINES = [
    ("plate-linuxcnc", {}), ("plate-linuxcnc", PLAIN), ("plate-codesys", {}),
    ("plate-codesys", PLAIN), ("laser-grbl", {"material": "wood"}),
    ("laser-grbl", {"material": "wood", "kerf_by": "offset", "kerf": 0.3}),
]  # fmt: skip
MOVE = re.compile(r"(?:N\d+ )?G0?([123]) ")
TOOL = re.compile(r"(?:N\d+ )?(?:M0?[345]|M1[35]|M6[45])\b")


def changed(lines: list[str], k: int, *now: str) -> str:
    return "\n".join([*lines[:k], *now, *lines[k + 1 :]])


def mutants(text: str) -> Iterator[tuple[str, str]]:
    """What is done to a program, and the program after it."""
    lines = text.split("\n")
    stops = [k for k, line in enumerate(lines) if re.search(r"(M0?5|M15|M65 P1)$", line)]
    tool_on = False
    for k, line in enumerate(lines):
        if TOOL.match(line):
            starts = not re.search(r"M0?5$|M15$|M65 P1$", line)
            if starts or tool_on:
                yield f"without {line}", changed(lines, k)
            tool_on = starts
        move = MOVE.match(line)
        if not move:
            continue
        yield f"without {line}", changed(lines, k)
        for letter in "XYIJ":
            for word in re.findall(rf"{letter}-?\d+\.?\d*", line):
                value = float(word[1:])
                other = line.replace(word, f"{letter}{value + 1:.3f}")
                yield f"{word} + 1 in {line}", changed(lines, k, other)
                if abs(value) > 0.5:
                    other = line.replace(word, f"{letter}{-value:.3f}")
                    yield f"{word} turned in {line}", changed(lines, k, other)
        if move[1] in "23":
            other = re.sub(r"G(0?)([23])", lambda m: f"G{m[1]}{5 - int(m[2])}", line)
            yield f"the other way round: {line}", changed(lines, k, other)
            straight = re.sub(r"G(0?)[23](.*?) I.*?J\S+", r"G\g<1>1\2", line)
            yield f"a line for {line}", changed(lines, k, straight)
        rapid = re.sub(r"G(0?)[123](.*?)(?: I.*)?$", r"G\g<1>0\2", line)
        yield f"a traverse for {line}", changed(lines, k, rapid)
    for k, line in enumerate(lines):
        if re.search(r"\bF\d", line):
            without = re.sub(r" ?\bF[\d.]+", "", line)
            if k < stops[0]:
                yield f"no feed in {line}", changed(lines, k, without)
            faster = re.sub(r"\bF[\d.]+", "F9999", line)
            yield f"F9999 in {line}", changed(lines, k, faster)
    for first, last in pairwise(stops):
        block = lines[first + 1 : last + 1]
        yield f"twice: {block[0]}", "\n".join([*lines[: last + 1], *block, *lines[last + 1 :]])
        yield f"not at all: {block[0]}", "\n".join([*lines[: first + 1], *lines[last + 1 :]])


@pytest.mark.parametrize("every", [11, pytest.param(1, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize(("name", "values"), MACHINES)
def test_every_mutant_is_found(name: str, values: dict[str, object], every: int) -> None:
    machine = table(name, **values)
    text = post((NESTED,), machine).text
    assert not verify_sheet(text, (NESTED,), machine)
    leads = set() if "lead" in values or name == "laser-grbl" else leads_of(text)
    count = 0
    for what, mutant in islice(mutants(text), 0, None, every):
        how, _, line = what.partition(" for " if " for " in what else " ")
        if line in leads and how in ("without", "a line"):
            continue  # in the waste: shorter or straight it is as good a lead
        count += 1
        assert verify_sheet(mutant, (NESTED,), machine), what
    assert count > 100 / every


def leads_of(text: str) -> set[str]:
    """The first and the last move of each cut."""
    cuts = re.findall(r"M0?3(?: S1)?\n(.*?)\n(?:N\d+ )?M0?5$", text, re.M | re.S)
    moves = [[line for line in cut.split("\n") if MOVE.match(line)] for cut in cuts]
    return {line for cut in moves for line in (cut[0], cut[-1])}


def test_whatever_the_planner_says_of_a_sheet_that_lies_it_is_refused() -> None:
    """A few of the lies on each machine; benchmarks/mutation.py tells all of them."""
    lies = told([m for m in LIARS if m[0] != "laser-stepper"], every=193)
    assert lies.missed == []
    assert sum(lies.made.values()) > 20
    assert {lie.split(" ")[0] for lie in lies.made} >= {"cut", "engrave", "mark"}
    steps = told([m for m in LIARS if m[0] == "laser-stepper"], every=397)
    assert steps.missed == []
    assert steps.made
