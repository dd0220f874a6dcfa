"""Rows of a cut chart that a machine file adds to those of its base."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.machine.load import settings
from beamcam.machine.overlay import with_more_rows
from beamcam.machine.torch import TorchRow

ROW = "[[torch.more_rows]]\nprocess = 'cut'\nup_to = {up_to}\nfeed_mm_min = {feed}\n"


def rows(path: Path) -> list[tuple[str, float, float]]:
    torch = load(str(path)).torch
    assert torch is not None
    assert torch.more_rows == ()
    return [(row.process, row.up_to, row.feed_mm_min) for row in torch.rows]


def test_a_row_more_needs_none_of_the_others(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("base = 'plate-linuxcnc'\n" + ROW.format(up_to=40, feed=260))
    base = load("plate-linuxcnc").torch
    assert base is not None
    before = [(row.process, row.up_to, row.feed_mm_min) for row in base.rows]
    assert sorted(rows(path)) == sorted([*before, ("cut", 40.0, 260.0)])
    assert {s.value for s in settings(str(path)) if s.key.endswith("up_to")} >= {32.0, 40.0}


def test_a_row_takes_the_place_of_one_for_the_same_sheet(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("base = 'plate-linuxcnc'\n" + ROW.format(up_to=6, feed=2000))
    assert [feed for process, up_to, feed in rows(path) if (process, up_to) == ("cut", 6.0)] == [
        2000.0
    ]


def test_rows_are_added_over_several_bases(tmp_path: Path) -> None:
    (tmp_path / "first.toml").write_text(
        "base = 'plate-linuxcnc'\n" + ROW.format(up_to=40, feed=260)
    )
    (tmp_path / "second.toml").write_text("base = 'first'\n" + ROW.format(up_to=50, feed=180))
    greatest = [up_to for process, up_to, _ in rows(tmp_path / "second.toml") if process == "cut"]
    assert greatest[-2:] == [40.0, 50.0]
    own = "base = 'first'\n[[torch.rows]]\nprocess = 'cut'\nup_to = 5\nfeed_mm_min = 9\n"
    (tmp_path / "third.toml").write_text(own + "[torch.colours]\nblue = 'ignore'\n")
    (tmp_path / "third.toml").write_text(
        own + "[[torch.rows]]\nprocess = 'mark'\nup_to = 9\nfeed_mm_min = 9\n"
    )
    assert rows(tmp_path / "third.toml") == [("cut", 5.0, 9.0), ("mark", 9.0, 9.0)]


@pytest.mark.parametrize(
    ("line", "code"), [("feed = 3", "machine-key"), ("kerf = '3'", "machine-value")]
)
def test_a_wrong_row_is_told_by_its_own_key(tmp_path: Path, line: str, code: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"base = 'plate-linuxcnc'\n{ROW.format(up_to=40, feed=260)}{line}\n")
    with pytest.raises(MachineError, match=r"torch\.more_rows\.0") as caught:
        load(str(path))
    (said,) = caught.value.diagnostics
    assert (said.code, said.source.line) == (code, 6)


MATERIALS = st.sampled_from(["*", "acrylic", "S*"])
UP_TO = st.sampled_from([3.0, 6.0, 12.0, 40.0])
ROWS = st.lists(st.tuples(MATERIALS, UP_TO), max_size=6, unique=True)


@given(ROWS, ROWS)
def test_each_added_row_is_found_for_its_own_sheet(
    rows: list[tuple[str, float]], more: list[tuple[str, float]]
) -> None:
    """The first row that fits a sheet of an added row's material and thickness is that row."""

    def table(some: list[tuple[str, float]], feed: int) -> list[dict[str, object]]:
        return [{"process": "cut", "material": m, "up_to": u, "feed_mm_min": feed} for m, u in some]

    chart = sorted(rows, key=lambda row: (row[0] == "*", row[1]))  # as a chart has to be written
    found = with_more_rows({"torch": {"rows": table(chart, 1), "more_rows": table(more, 2)}})
    merged = [TorchRow(**row) for row in found["torch"]["rows"]]
    for material, up_to in more:
        first = next(r for r in merged if r.material == material and up_to <= r.up_to)
        assert (first.up_to, first.feed_mm_min) == (up_to, 2)
    if more:
        order = [row.material == "*" for row in merged]
        assert order == sorted(order)
