"""Programs of samples and real files beside the solids of their parts: a third opinion on each."""

from pathlib import Path

import pytest

from benchmarks.solid_cases import cases
from tests.conftest import CORPUS

OURS = pytest.param(None, 60, marks=pytest.mark.exhaustive)
REAL = pytest.param(CORPUS, 150, marks=pytest.mark.third_party)


@pytest.mark.parametrize("stock", ["bars", "plates"])
@pytest.mark.parametrize(("corpus", "least"), [OURS, REAL])
def test_solids_agree_with_programs(stock: str, corpus: Path | None, least: int) -> None:
    found = [(case.name, case.said(case.text, ("all",))) for case in cases(corpus, [stock])]
    assert len(found) >= least
    # solid-none: the cuts of the drawing enclose no piece.
    wrong = [f"{name}: {d}" for name, said in found for d in said if d.code != "solid-none"]
    assert wrong == []
