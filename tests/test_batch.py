"""`beamcam batch`: what is posted, in which order, under which name, and what is said of it."""

import csv
import json
import os
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

import beamcam
from tests.conftest import SAMPLES, sampled
from tests.runs import BAD, batch, call, counts, fill, part, programs, report


@pytest.fixture
def jobs(tmp_path: Path) -> Path:
    """Four parts in two folders."""
    fill(tmp_path / "in" / "A", 2)
    fill(tmp_path / "in" / "B", 2)
    return tmp_path / "in"


def test_one_bad_file_stops_no_other(tmp_path: Path) -> None:
    """200 files of which one is bad: 199 outputs, exit status 1, and the report lists the one."""
    fill(tmp_path / "in", 200, bad=77)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--jobs", 2, "--report",
                   tmp_path / "report.json", status=1)  # fmt: skip
    assert counts(result) == (199, 0, 1, 0)
    assert len(programs(tmp_path / "out")) == 199
    data = report(tmp_path / "report.json")
    assert data["counts"] == {"posted": 199, "unchanged": 0, "refused": 1, "failed": 0}
    names = [row["file"] for row in data["files"]]
    assert names == [str(tmp_path / "in" / f"P{k:03d}.nc1") for k in range(200)]
    (bad,) = (row for row in data["files"] if row["status"] != "posted")
    assert bad["file"].endswith("P077.nc1")
    assert [m["code"] for m in bad["messages"]] == ["plan-tool", "plan-no-machine"]
    assert bad["messages"][0]["line"] == 28
    assert f"{bad['file']}:28: error plan-tool" in result.stderr


def test_each_part_is_posted_as_by_itself(tmp_path: Path) -> None:
    result = batch(SAMPLES / "dstv", "-o", tmp_path / "out", "--bar", 12000, "--each")
    made = programs(tmp_path / "out")
    assert {"channel.gcode", "gusset.ngc"} <= set(made)
    made = {name: text for name, text in made.items() if not name.endswith(".csv")}
    assert counts(result)[0] == len(made)
    for name, text in made.items():
        sample = SAMPLES / "dstv" / f"{Path(name).stem}.nc1"
        args = ["post", str(sample), "-o", "-", "--bar", "12000"]
        assert call(*args).stdout_bytes == text


@pytest.mark.parametrize("workers", sampled([2, 4], 2))
def test_workers_change_nothing(tmp_path: Path, workers: int) -> None:
    """150 inputs with 1, 2 and 4 workers: the same bytes, rows in the same order."""
    fill(tmp_path / "in", 150, bad=75)
    (tmp_path / "in" / "P100.nc1").write_text("")
    rows = []
    for jobs in (1, workers):
        out, said = tmp_path / str(jobs), tmp_path / f"{jobs}.json"
        assert batch(tmp_path / "in", "-o", out, "--jobs", jobs, "--report", said).exit_code == 1
        rows.append([{**row, "seconds": 0} for row in report(said)["files"]])
    assert rows[0] == rows[1]
    assert programs(tmp_path / "1") == programs(tmp_path / str(workers))
    assert len(programs(tmp_path / "1")) == 148


def test_unchanged_inputs_are_left_alone(jobs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert counts(batch(jobs, "-o", out)) == (4, 0, 0, 0)
    before = {path: os.stat(out / path).st_mtime_ns for path in programs(out)}
    again = batch(jobs, "-o", out, status=0)
    assert counts(again) == (0, 4, 0, 0)
    assert {path: os.stat(out / path).st_mtime_ns for path in programs(out)} == before
    assert counts(batch(jobs, "-o", out, "--force")) == (4, 0, 0, 0)


def test_what_changed_is_done_again(jobs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    batch(jobs, "-o", out)
    good = programs(out)
    (jobs / "A" / "P000.nc1").write_text(part("P0-1", 1600.0))  # the input
    (out / "A" / "P001.gcode").write_text("edited")  # an output
    (out / "B" / "P000.gcode").unlink()
    assert counts(batch(jobs, "-o", out)) == (2, 1, 1, 0)  # an edit is not lost
    assert (out / "A" / "P001.gcode").read_text() == "edited"
    assert counts(batch(jobs, "-o", out, "--force")) == (4, 0, 0, 0)
    now = programs(out)
    assert {path for path in now if now[path] != good[path]} == {"A/P000.gcode"}
    assert counts(batch(jobs, "-o", out, "--job", "NIGHT")) == (4, 0, 0, 0)
    assert counts(batch(jobs, "-o", out, "--job", "NIGHT", "--bar", 6000, "--each")) == (4, 0, 0, 0)
    machine = tmp_path / "mine.toml"
    machine.write_text('base = "beamline"\n[drill]\nclearance = 6\n')
    assert counts(batch(jobs, "-o", out, "--machine", machine)) == (4, 0, 0, 0)
    assert counts(batch(jobs, "-o", out, "--machine", machine)) == (0, 4, 0, 0)
    machine.write_text('base = "beamline"\n[drill]\nclearance = 7\n')
    assert counts(batch(jobs, "-o", out, "--machine", machine)) == (4, 0, 0, 0)


def test_a_report_of_unchanged_files_is_as_full(jobs: Path, tmp_path: Path) -> None:
    said = tmp_path / "report.json"
    batch(jobs, "-o", tmp_path / "out")  # without times, since nobody asked for them
    batch(jobs, "-o", tmp_path / "out", "--report", said)
    first = report(said)["files"]
    assert all(row["parts"][0]["machine_time_s"] > 0 for row in first)
    batch(jobs, "-o", tmp_path / "out", "--report", said)
    second = report(said)
    assert second["counts"]["unchanged"] == 4
    assert [row["parts"] for row in second["files"]] == [row["parts"] for row in first]
    assert [row["messages"] for row in second["files"]] == [row["messages"] for row in first]


def test_same_names_are_kept_apart_or_refused(jobs: Path, tmp_path: Path) -> None:
    batch(jobs / "A", jobs / "B", "-o", tmp_path / "tree", status=0)
    assert sorted(programs(tmp_path / "tree")) == [
        "A/P000.gcode", "A/P001.gcode", "B/P000.gcode", "B/P001.gcode",
    ]  # fmt: skip
    flat = batch(jobs / "A", jobs / "B", "-o", tmp_path / "flat", "--flat", "--jobs", 2, status=1)
    assert counts(flat) == (2, 0, 2, 0)
    first, second = jobs / "A" / "P000.nc1", jobs / "B" / "P000.nc1"
    assert (
        f"{second}: error batch-same-name: found 'P000.gcode' for the output's name, "
        f"which {first} has" in flat.stderr
    )
    assert programs(tmp_path / "flat") == {
        f"P{k:03d}.gcode": (tmp_path / "tree" / "A" / f"P{k:03d}.gcode").read_bytes()
        for k in range(2)
    }


def test_a_name_that_was_taken_since_is_not_unchanged(tmp_path: Path) -> None:
    for folder in ("A", "B"):
        (tmp_path / "in" / folder).mkdir(parents=True)
    (tmp_path / "in" / "B" / "M.nc1").write_text(part("M"))
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out", "--flat")) == (1, 0, 0, 0)
    (tmp_path / "in" / "A" / "M.nc1").write_text(part("N", 3000.0))
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out", "--flat")) == (1, 0, 1, 0)


def test_placeholders_in_the_name(jobs: Path, tmp_path: Path) -> None:
    batch(jobs / "A", "-o", tmp_path / "out", "--name", "{mark}_{quantity}.gcode", status=0)
    assert sorted(programs(tmp_path / "out")) == ["P0_1.gcode", "P1_2.gcode"]
    name = "{profile}/{grade}-{order}-{number:03d}-{stem}-{machine}{suffix}"
    batch(jobs / "A", "-o", tmp_path / "more", "--name", name)
    assert "UPN200/S235JR-TEST-001-P000-beamline.gcode" in programs(tmp_path / "more")


def test_a_mark_cannot_leave_the_folder(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.nc1").write_text(part("../../x/1"))
    assert batch(tmp_path / "in", "-o", tmp_path / "out", "--name", "{mark}.gcode").exit_code == 0
    assert list(programs(tmp_path / "out")) == ["_.._x_1.gcode"]


@pytest.mark.parametrize(
    ("template", "said"),
    [
        ("{marc}.gcode", "found {marc} in '{marc}.gcode'; expected one of {stem}, {mark}"),
        ("{}.gcode", "found {} in '{}.gcode'; expected one of"),
        ("{mark", "expected '}'"),
        ("../{mark}", "expected names between the slashes"),
        ("/tmp/{mark}", "expected a path below the output folder"),
        ("a//{mark}", "expected names between the slashes"),
        ("{mark:d}", "Unknown format code 'd'"),
        ("{mark.__class__}", "found {mark.__class__}"),
    ],
)
def test_templates_that_are_none(tmp_path: Path, template: str, said: str) -> None:
    result = batch(SAMPLES / "dstv", "-o", tmp_path / "out", "--name", template, status=2)
    assert said in re.sub(r"\s+", " ", result.stderr)
    assert not (tmp_path / "out").exists()


def test_a_template_that_does_not_tell_files_apart(jobs: Path, tmp_path: Path) -> None:
    result = batch(jobs / "A", "-o", tmp_path / "out", "--name", "one{suffix}")
    assert counts(result) == (1, 0, 1, 0)
    assert "batch-same-name: found 'one.gcode'" in result.stderr


def test_an_input_is_not_written_over(jobs: Path) -> None:
    before = programs(jobs)
    result = batch(jobs, "-o", jobs, "--name", "{stem}.nc1")
    assert counts(result) == (0, 0, 4, 0)
    assert "batch-over-input: found the output 'A/P000.nc1', which is" in result.stderr
    assert programs(jobs) == before
    assert counts(batch(jobs, "-o", jobs)) == (4, 0, 0, 0)  # beside its input it may stand


def test_inputs_of_all_kinds_at_once(jobs: Path, tmp_path: Path) -> None:
    """A folder, a pattern, a file, a list on standard input; a file named twice is taken once."""
    args = (jobs / "A", f"{jobs}/B/*1.nc1", "-", jobs / "A" / "P000.nc1", "-o", tmp_path / "out")
    result = batch(*args, stdin=f"{jobs}/B/P000.nc1\n")
    assert counts(result) == (4, 0, 0, 0)
    assert len(programs(tmp_path / "out")) == 4


def test_formats_are_mixed(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.nc1").write_text(part("A"))
    (tmp_path / "in" / "notes.txt").write_text("not for the machine")
    args = ["convert", str(tmp_path / "in" / "a.nc1"), "-o", str(tmp_path / "in" / "b.json")]
    assert call(*args).exit_code == 0
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--report", tmp_path / "r.json")
    made = programs(tmp_path / "out")
    assert result.exit_code == 0
    assert made["a.gcode"] == made["b.gcode"]
    assert [row["format"] for row in report(tmp_path / "r.json")["files"]] == ["dstv", "part-json"]


def test_bars_sheets_and_models_go_to_their_machines(tmp_path: Path) -> None:
    """A folder of all formats: each program is the one that post makes of that file by itself."""
    folder = tmp_path / "in"
    folder.mkdir()
    names = {
        "dstv/channel.nc1": ".gcode", "dstv/gusset.nc1": ".ngc", "dxf/plate.dxf": ".ngc",
        "svg/corel-2021.svg": ".ngc", "json/curves.json": ".ngc", "ifc/bolted.ifc": ".gcode",
    }  # fmt: skip
    for name in names:
        (folder / Path(name).name).write_bytes((SAMPLES / name).read_bytes())
    how = ("--bar", "12000", "--thickness", "4", "--map", "blue=cut", "--allow-open")
    said = tmp_path / "r.json"
    result = batch(folder, "-o", tmp_path / "out", *how, "--each", "--jobs", 2, "--report", said)
    assert counts(result) == (6, 0, 0, 0)
    made = programs(tmp_path / "out")
    machines = {
        row["file"].rpartition("/")[2]: row["parts"][0]["machine"] for row in report(said)["files"]
    }
    for name, suffix in names.items():
        source, target = folder / Path(name).name, tmp_path / f"one{suffix}"
        (read,) = beamcam.read(source).parts
        # Thickness and map are for the drawings of the folder.
        flat = () if read.profile.web_thickness is not None else how[2:]
        flat = how[:2] if suffix == ".gcode" else flat
        args = ["post", str(source), "-o", str(target), *flat]
        assert call(*args).exit_code == 0
        assert made[f"{source.stem}{suffix}"] == target.read_bytes()
        assert machines[source.name] == ("beamline" if suffix == ".gcode" else "plate-linuxcnc")
    assert counts(batch(folder, "-o", tmp_path / "out", *how, "--each")) == (0, 6, 0, 0)
    # An option for sheets where no machine of the run cuts any is a mistake.
    result = batch(folder, "-o", tmp_path / "no", "--machine", "beamline", "--kerf", "1", status=1)
    assert "plan-sheet-option" in result.stderr


def test_reports(jobs: Path, tmp_path: Path) -> None:
    (jobs / "A" / "bad <b>&.nc1").write_text(BAD)
    made = {}
    for kind in ("json", "csv", "html"):
        path = tmp_path / f"report.{kind}"
        assert batch(jobs, "-o", tmp_path / kind, "--report", path).exit_code == 1
        made[kind] = path.read_text(encoding="utf-8")
    row = json.loads(made["json"])["files"][0]
    assert row["status"] == "posted"
    assert row["seconds"] > 0
    (first,) = row["parts"]
    assert first["ledger"] == {
        "read": 1,
        "made": 1,
        "merged": 0,
        "duplicate": 0,
        "listed": 0,
        "skipped": 0,
        "passed_on": 0,
    }
    assert first["tools"] == ["drill 18", "saw"]
    assert first["output"] == "A/P000.gcode"
    assert first["machine"] == "beamline"
    assert first["machine_time_s"] > 10
    rows = list(csv.DictReader(made["csv"].splitlines()))
    assert [r["status"] for r in rows] == ["posted", "posted", "refused", "posted", "posted"]
    assert rows[0]["tools"] == "drill-18 saw"
    assert float(rows[0]["machine_time_s"]) == pytest.approx(first["machine_time_s"], abs=0.06)
    assert rows[2]["errors"] == "2"  # and that no other machine makes it
    assert "plan-tool" in rows[2]["messages"]
    page = Page(made["html"])
    assert page.cells.count("posted") == 5  # and in the filter
    assert page.cells.count("beamline") == 6  # and in the filter and the totals
    assert page.cells.count("1 read = 1 made") == 4
    times = [float(r["machine_time_s"]) * int(r["quantity"]) for r in rows if r["machine_time_s"]]
    minutes, seconds = page.cells[page.cells.index("beamline") + 1].split()[0].split(":")
    assert int(minutes) * 60 + int(seconds) == pytest.approx(sum(times), abs=1)
    assert any(cell.endswith("bad <b>&.nc1") for cell in page.cells)
    assert made["html"].count("<script") == 1  # the page's own


class Page(HTMLParser):
    """The texts of a page's table."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.cells: list[str] = []
        self.feed(text)

    def handle_data(self, data: str) -> None:
        self.cells.append(data.strip())


def test_the_report_may_be_printed(jobs: Path, tmp_path: Path) -> None:
    result = batch(jobs, "-o", tmp_path / "out", "--report", "-", "-q")
    assert json.loads(result.stdout)["counts"]["posted"] == 4
    assert result.stderr == ""


def test_a_spreadsheet_runs_nothing_of_a_report(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.nc1").write_text(part('=HYPERLINK("x")'))
    batch(tmp_path / "in", "-o", tmp_path / "out", "--report", tmp_path / "r.csv")
    (row,) = csv.DictReader((tmp_path / "r.csv").read_text().splitlines())
    assert row["mark"] == '\'=HYPERLINK("x")'


def test_what_is_printed(jobs: Path, tmp_path: Path) -> None:
    (jobs / "A" / "bad.nc1").write_text(BAD)
    plain = batch(jobs, "-o", tmp_path / "1")
    assert plain.stdout == ""
    assert len(plain.stderr.splitlines()) == 5
    assert plain.stderr.count("warning plan-quantity") == 2
    assert "warning plan-quantity: 1 more; --verbose or the report shows them" in plain.stderr
    assert plain.stderr.splitlines()[-1] == "4 posted, 0 unchanged, 1 refused, 0 failed"
    assert "\x1b" not in plain.stderr
    quiet = batch(jobs, "-o", tmp_path / "2", "--quiet")
    assert len(quiet.stderr.splitlines()) == 2
    assert "plan-tool" in quiet.stderr
    verbose = batch(jobs, "-o", tmp_path / "3", "--verbose")
    assert f"{jobs}/A/P001.nc1: posted A/P001.gcode" in verbose.stderr
    assert "warning plan-quantity" in verbose.stderr


def test_strict_and_skips(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "bad.nc1").write_text(BAD)
    said = tmp_path / "r.json"
    result = batch(
        tmp_path / "in", "-o", tmp_path / "out", "--allow-skips", "tool", "--report", said
    )
    assert counts(result) == (1, 0, 0, 0)
    (row,) = report(said)["files"][0]["parts"]
    assert row["ledger"]["skipped"] == 1
    assert row["skipped_by"] == {"plan-tool": 1}
    text = (SAMPLES / "dstv" / "channel.nc1").read_text().replace("     15.000\n", "0.000\n", 1)
    (tmp_path / "in" / "bad.nc1").write_text(text)
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out"))[0] == 1
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out", "--strict")) == (0, 0, 1, 0)


def test_an_unverified_program_says_so(jobs: Path, tmp_path: Path) -> None:
    batch(jobs, "-o", tmp_path / "1")
    batch(jobs, "-o", tmp_path / "2", "--no-verify")
    one, two = (programs(tmp_path / name)["A/P000.gcode"] for name in "12")
    assert len(two.splitlines()) == len(one.splitlines()) + 1


def test_stock_lengths_of_the_configuration(tmp_path: Path) -> None:
    """A part takes the shortest bar that it fits on, kerf and trim included."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "beamcam.toml").write_text("stock_lengths = [12000, 2000, 6000, 1300]\n")
    for name, length in (("a", 300.0), ("b", 1295.0), ("c", 1999.0), ("d", 7000.0), ("e", 11999.0)):
        (tmp_path / "in" / f"{name}.nc1").write_text(part(name, length))
    said = tmp_path / "r.json"
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--report", said, "--trust", tmp_path)
    rows = report(said)["files"]
    bars = [[p["bar"] for p in row["parts"]] for row in rows]
    assert bars == [[1300.0], [2000.0], [6000.0], [12000.0], []]
    assert counts(result) == (4, 0, 1, 0)
    assert "plan-bar-full" in result.stderr
    assert "expected at most the bar's 12000.000 mm" in result.stderr


def test_a_refused_file_tells_of_its_older_program(jobs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    batch(jobs, "-o", out)
    (jobs / "A" / "P000.nc1").write_text(BAD)
    result = batch(jobs, "-o", out)
    assert counts(result) == (0, 3, 1, 0)
    assert "warning batch-stale: 'A/P000.gcode' still stands from an earlier run" in result.stderr


@pytest.mark.parametrize(
    "args",
    [(), ("in",), ("in", "-o", "out", "--jobs", "0"), ("in", "-o", "out", "--report", "x.pdf"),
     ("in", "-o", "out", "--bar", "-1"), ("in", "-o", "out", "--allow-skips", "every")],
)  # fmt: skip
def test_wrong_usage(args: tuple[str, ...]) -> None:
    assert batch(*args).exit_code == 2


def test_an_unknown_machine(tmp_path: Path) -> None:
    result = batch(SAMPLES / "dstv", "-o", tmp_path / "out", "--machine", "beamlime", status=1)
    assert "machine-unknown" in result.stderr
    assert not (tmp_path / "out").exists()
