"""Faulty programs are caught, and programs that only look different are not."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.bars import run
from beamcam.comparison.bars import diff_programs
from beamcam.errors import errors_in
from benchmarks import feed_faults, sheet_faults
from benchmarks.faults import FAULTS, NEED_PARTS, SEEN_BY_PARTS
from benchmarks.liars import told
from benchmarks.mutants import MUTATIONS, REWRITES, Mutate, wrong_spindle
from benchmarks.mutation import (
    MACHINES,
    Case,
    Score,
    all_kinds,
    beyond_limits,
    cases,
    changed,
    faults,
    outcome,
    score,
)
from benchmarks.sheet_faults import told as faults_of_tables
from tests.conftest import examples

MUTANTS = 300


@pytest.fixture(scope="module")
def programs() -> list[Case]:
    return list(cases())


@pytest.fixture(scope="module")
def result(programs: list[Case]) -> Score:
    return score(MUTANTS, 3, programs)


def test_every_program_passes_as_it_was_emitted(programs: list[Case]) -> None:
    for case in programs:
        assert case.said(case.text) == (), case.name


def test_every_mutant_that_makes_something_else_is_caught(result: Score) -> None:
    assert sum(result.made.values()) >= MUTANTS
    assert [(name, mutation) for name, mutation, _ in result.missed] == []


def test_every_kind_of_mutation_took_part(result: Score) -> None:
    assert set(result.made) == {mutate.__name__ for mutate in MUTATIONS}


def test_unchanged_meaning_raises_nothing(result: Score, programs: list[Case]) -> None:
    assert result.rewrites == len(REWRITES) * len(programs)
    assert result.false_alarms == []


def test_what_breaks_a_tool_is_refused_with_and_without_parts(programs: list[Case]) -> None:
    result = faults(1, 5, [*programs, all_kinds()])
    assert set(result.made) == {fault.__name__ for fault in FAULTS}
    assert result.missed == []
    for name, count in result.made.items():
        assert name in NEED_PARTS or result.alone[name] == count, name


def test_what_a_smaller_machine_cannot_run_is_refused(programs: list[Case]) -> None:
    result = beyond_limits([*programs, all_kinds()])
    assert result.missed == []
    assert len(result.made) == 7
    assert result.made["section"] == len(programs) + 1


#: The tables that have every fault between them; a benchmark and the exhaustive run tell all.
TABLES = tuple(sheet_faults.TABLES[k] for k in (1, 4, 5, 6, 7))


@pytest.mark.parametrize(
    "tables", [TABLES, pytest.param(sheet_faults.TABLES, marks=pytest.mark.exhaustive)], ids=len
)
def test_faults_of_tables_are_refused(
    tables: tuple[tuple[str, dict[str, object]], ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of each class: order, state, limits, leads, direction, heights, what is switched."""
    monkeypatch.setattr(sheet_faults, "TABLES", tables)
    result = faults_of_tables(1, 37)
    assert result.missed == []
    classes = {kind.split(" ")[0] for kind in result.made}
    assert classes == {*sheet_faults.BY_CLASS, "direction"}
    names = {kind.split(" ")[1] for kind in result.made} - {"turned"}
    assert names == {name for many in sheet_faults.BY_CLASS.values() for name in many}


def test_faults_of_feeds_and_of_common_cuts_are_refused() -> None:
    """And programs that mean the same are not."""
    result = feed_faults.told(1, 7)
    assert result.missed == []
    names = {kind.split(" ")[1] for kind in result.made}
    assert names == {f.__name__ for many in feed_faults.BY_CLASS.values() for f in many}


def test_whatever_the_planner_says_of_a_plan_that_lies_it_is_refused() -> None:
    lies = told(MACHINES, every=14)
    assert lies.missed == []
    assert sum(lies.made.values()) > 250
    kinds = {lie.split(" ")[0] for lie in lies.made}
    assert kinds == {
        "cut", "drill", "tap", "countersink", "punch", "mill", "scribe", "piece", "without",
    }  # fmt: skip


def test_a_program_that_breaks_a_tool_is_never_the_same(programs: list[Case]) -> None:
    rng = random.Random(7)
    for case in programs:
        step = case.machine.format.resolution
        good = run(case.text, case.machine)
        assert errors_in(good.diagnostics) == ()
        assert diff_programs(good.made, good.made, step) == ()
        for fault in FAULTS:
            found = fault(case.text.split("\n"), rng)
            if found is not None:
                bad = run("\n".join(found), case.machine)
                said = errors_in(bad.diagnostics)
                differs = said or diff_programs(good.made, bad.made, step)
                assert differs or fault.__name__ in SEEN_BY_PARTS, fault.__name__


def test_rewrites_do_change_the_text(programs: list[Case]) -> None:
    rng = random.Random(0)
    for rewrite in REWRITES:
        assert any(rewrite(case.text, rng) != case.text for case in programs), rewrite.__name__


def test_the_outcome_tells_a_change_from_none(programs: list[Case]) -> None:
    case = programs[0]
    before, step = outcome(case.text), case.machine.format.resolution
    drilled = next(line for line in case.text.splitlines() if " G01 " in line and " Z" in line)
    shifted = case.text.replace(drilled, drilled.replace(" X", " X1", 1), 1)
    assert changed(before, outcome(shifted), case.parts[0], step)
    assert not changed(before, outcome(case.text), case.parts[0], step)
    assert not changed(before, outcome(case.text.replace(" F1", " F2")), case.parts[0], step)


@settings(max_examples=examples(150))
@given(st.randoms(use_true_random=False), st.integers(0, 100))
def test_mutations_follow_one_another(programs: list[Case], rng: random.Random, pick: int) -> None:
    """Each takes what those before it left, down to a program of nothing."""
    case = programs[pick % len(programs)]
    text = case.text
    for _ in range(8):
        before = text.split("\n")
        after = rng.choice(MUTATIONS)(list(before), rng, case.machine.format.resolution)
        assert after is None or abs(len(after) - len(before)) <= len(before)
        text = "\n".join(before if after is None else after)
        if rng.random() < 0.2:
            text = rng.choice(REWRITES)(text, rng)


@pytest.mark.parametrize("mutate", MUTATIONS)
def test_nothing_is_not_broken(mutate: Mutate) -> None:
    for text in ("", "%", "% P1\n\n(N1 G90)", "N1"):
        after = mutate(text.split("\n"), random.Random(1), 0.001)
        assert after is None or "N1" in text


@pytest.mark.parametrize("word", ["K-2", "K2.5", "K", "K13"])
def test_a_spindle_of_any_number_becomes_another(word: str) -> None:
    after = wrong_spindle([f"N1 M40 {word} L14"], random.Random(1), 0.001)
    assert after in ([f"N1 M40 K{n} L14"] for n in (1, 2, 3, 13))
    assert after != [f"N1 M40 {word} L14"]
