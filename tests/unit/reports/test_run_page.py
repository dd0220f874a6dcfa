"""The page of a run: refused files first, totals, links to sheets, and nothing else fetched."""

import re
from hashlib import sha256
from pathlib import Path

import pytest

from beamcam.reports.run import Counts, FileRow, PartRow
from beamcam.reports.run_page import Extra, as_html
from tests.conftest import SAMPLES, sampled
from tests.runs import call


def part(mark: str, machine: str, quantity: int = 1, pieces: int = 1) -> PartRow:
    return {
        "mark": mark, "quantity": quantity, "pieces": pieces, "profile": "IPE300", "length": 4000.0,
        "machine": machine, "output": f"{mark}.gcode", "sha256": "", "rest": None, "bar": 6000.0,
        "ledger": {"read": 1, "made": 1, "merged": 0, "duplicate": 0, "listed": 0, "skipped": 0,
                   "passed_on": 0},
        "by_hand": [], "skipped_by": {}, "mapped": {}, "tools": ["drill 18", "saw"],
        "operations": 3, "machine_time_s": 60.0,
    }  # fmt: skip


def row(name: str, status: str, *parts: PartRow) -> FileRow:
    return {
        "file": name, "status": status, "format": "dstv", "seconds": 0.001, "parts": list(parts),
        "messages": [],
    }  # type: ignore[typeddict-item]  # fmt: skip


ROWS = [
    row("a.nc1", "posted", part("A", "beamline", 6, 2)), row("b.nc1", "refused"),
    row("c.nc1", "unchanged", part("C", "pusher"), part("<D>", "beamline")),
    row("d.nc1", "failed"),
]  # fmt: skip


def page(extras: dict[str, Extra] | None = None) -> str:
    counts = Counts()
    for one in ROWS:
        counts.add(one)
    return b"".join(as_html(lambda: ROWS, counts, [], extras)).decode()


def test_refused_files_stand_first_and_all_are_there() -> None:
    files = re.findall(r"<tr data-status=(\w+)><td>([^<]+)", page())
    assert files == [("refused", "b.nc1"), ("failed", "d.nc1"), ("posted", "a.nc1"),
                     ("unchanged", "c.nc1")]  # fmt: skip


def test_totals_count_pieces_time_and_stock_by_machine() -> None:
    text = page()
    rows = dict(re.findall(r"<tr><td>(beamline|pusher|all)(<td class=\"n\">.*?)</tr>", text))
    figures = {name: re.findall(r'"n">([^<]+)', cells) for name, cells in rows.items()}
    assert figures == {
        "beamline": ["4:00 min", "2", "7", "24.00"], "pusher": ["1:00 min", "1", "1", "6.00"],
        "all": ["5:00 min", "3", "8", "30.00"],
    }  # fmt: skip
    assert "drill 18 (2), saw (2)" in text


def test_a_row_links_to_its_sheet_and_shows_a_picture() -> None:
    text = page({"A.gcode": Extra("r.sheets/A b.gcode.html", "<svg></svg>")})
    assert '<a href="r.sheets/A%20b.gcode.html">A.gcode</a><svg></svg>' in text
    assert "<D>" not in text
    assert "&lt;D&gt;" in text
    assert re.findall(r'(?:src|href)="([^"]*)"', text) == ["data:,", "r.sheets/A%20b.gcode.html"]


@pytest.mark.parametrize("jobs", sampled(["2", "1"], 2))
def test_a_batch_has_a_sheet_for_each_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: str
) -> None:
    monkeypatch.setattr("beamcam.commands.batch.FILES_A_WORKER", 1)
    inputs = [str(SAMPLES / "dstv" / f"{n}.nc1") for n in ("channel", "tie", "gusset", "purlin")]
    words = ["batch", *inputs, "-o", str(tmp_path / "out"), "--jobs", jobs, "--report",
             str(tmp_path / "r.html")]  # fmt: skip
    assert call(*words).exit_code == 1  # the purlin is refused
    text = (tmp_path / "r.html").read_text()
    links = re.findall(r'href="(r\.sheets/[^"]+)"', text)
    assert len(links) == 3
    for link in links:
        sheet = (tmp_path / link).read_text()
        program = tmp_path / "out" / Path(link).name.removesuffix(".html")

        assert f'data-sha256="{sha256(program.read_bytes()).hexdigest()}"' in sheet
        assert "exactly these parts" in sheet
    assert text.count("<svg") == 3
    before = text
    assert call(*words).exit_code == 1
    again = (tmp_path / "r.html").read_text()
    assert re.findall(r'href="(r\.sheets/[^"]+)"', again) == links
    assert before != again  # posted, then unchanged
    # A program that was changed by hand since is posted again, and so has its sheet.
    assert "unchanged" in again
