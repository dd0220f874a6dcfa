"""Letterings that are not what the part asks for are refused, on every machine that letters."""

from collections import Counter
from pathlib import Path

import pytest

from beamcam.errors import PlanError, ReadError
from beamcam.machine import load
from beamcam.model.part import TextMark
from beamcam.model.request import stock_of
from beamcam.pipeline import parts_of, post, read_file
from benchmarks.letterings import CHANGES, MACHINES, letterings
from tests.conftest import CORPUS

FILES = sorted((CORPUS / "dstv").glob("*/*.[nN][cC]*"))


@pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_wrong_lettering_is_refused(every: int) -> None:
    tried = [*letterings(1, 7, MACHINES[::every])]
    made = Counter(name for name, _ in tried)
    refused = Counter(name for name, is_refused in tried if is_refused)
    assert {*made} == {change.__name__ for change in CHANGES} | {"another_face"}
    assert refused == made


@pytest.mark.third_party
@pytest.mark.parametrize("bars", ["beamline", "beamline-pusher"])
def test_every_text_of_a_real_part_is_lettered_or_listed(bars: str) -> None:
    lines = {"beam": load(bars), "sheet": load("plate-linuxcnc")}
    counts = {"made": 0, "listed": 0}
    posted = 0
    for path in FILES:
        try:
            parts, _ = parts_of([read_file(str(path))])
            done = post(parts[:1], lines[stock_of(parts[:1])], skips=("all",))
        except (ReadError, PlanError):
            continue
        posted += 1
        by_feature = {o.feature[1]: o.how for o in done.plan.outcomes}
        texts = [f for f, x in enumerate(parts[0].features) if isinstance(x, TextMark)]
        for f in texts:
            counts[by_feature[f]] += 1
        assert all(by_feature[f] in counts for f in texts), Path(path).name
    assert posted >= 15
    assert counts["made"] >= 8
    assert counts["listed"] >= (8 if bars == "beamline" else 0)
