"""`batch` over stock: the parts of all files share bars, remnants and sheets."""

import csv
import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.batch import over_stock, work
from beamcam.batch.find import Input
from beamcam.batch.pool import Here, driven
from beamcam.batch.run import RunSetup
from beamcam.batch.run import run as run_files
from beamcam.batch.shares import FileState
from beamcam.batch.work import BatchSettings
from beamcam.checks.job import Head, head_of
from beamcam.machine import load
from beamcam.model.request import Request
from beamcam.pipeline import read_file
from beamcam.processes import Died
from beamcam.readers import Reading
from beamcam.system import NEVER
from tests.conftest import SAMPLES, examples
from tests.runs import BAD, call, part

DSTV = SAMPLES / "dstv"


def order(folder: Path, *names: str) -> Path:
    """A folder with samples of DSTV."""
    folder.mkdir()
    for name in names or ("channel", "tie", "beam", "strut", "gusset"):
        (folder / f"{name}.nc1").write_bytes((DSTV / f"{name}.nc1").read_bytes())
    return folder


def heads(folder: Path) -> dict[str, Head]:
    found = {}
    for path in sorted(folder.iterdir()):
        if path.suffix in (".gcode", ".ngc"):
            head = head_of(path.read_text())
            assert head is not None
            found[path.name] = head
    return found


def marks(head: Head) -> list[str]:
    return [told.texts.split()[1] for told in head.parts]


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    with open(folder / name, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@settings(max_examples=examples(12), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.tuples(st.integers(300, 5900), st.integers(1, 4)), min_size=1, max_size=9),
    st.lists(st.sampled_from((2500, 4300, 7000)), max_size=3),
)
def test_each_piece_is_made_once_from_what_is_in_store(
    tmp_path_factory: pytest.TempPathFactory, pieces: list[tuple[int, int]], remnants: list[int]
) -> None:
    folder = tmp_path_factory.mktemp("run")
    (folder / "in").mkdir()
    for k, (length, quantity) in enumerate(pieces):
        (folder / "in" / f"P{k}.nc1").write_text(part(f"P{k}", float(length), quantity))
    words = [word for length in remnants for word in ("--remnant", length)]
    call("batch", folder / "in", "--bar", 6000, *words, "-o", folder / "out", "--jobs", 1, status=0)
    made = heads(folder / "out")
    assert Counter(mark for head in made.values() for mark in marks(head)) == {
        f"P{k}": quantity for k, (_, quantity) in enumerate(pieces)
    }
    used = Counter(head.bar for head in made.values())
    assert {*used} <= {6000.0, *map(float, remnants)}
    assert not any(used[float(length)] > remnants.count(length) for length in {*remnants})
    assert [head.program for head in made.values()] == [
        (number, len(made)) for number in sorted(range(1, len(made) + 1), key=str)
    ]
    for row in rows(folder / "out", "bars.csv"):
        assert float(row["remnant"]) >= 0.0


def test_programs_lists_and_labels_are_of_one_plan(tmp_path: Path) -> None:
    out = tmp_path / "out"
    call(
        "batch", order(tmp_path / "in"), "--bar", 12000, "--remnant", "UPN200=4300", "--sheet",
        "3000x1500", "-o", out, status=0,
    )  # fmt: skip
    made = heads(out)
    assert {name: (head.bar, marks(head)) for name, head in made.items()} == {
        "IPE160_S235JR.gcode": (12000.0, ["S1"]), "IPE300_S355J2.gcode": (12000.0, ["B1"]),
        "PL6_S355J2.ngc": (None, ["G1"]), "UPN200_S235JR-1.gcode": (4300.0, ["C1", "T1"]),
        "UPN200_S235JR-2.gcode": (12000.0, ["T1"]),
    }  # fmt: skip
    cuts = rows(out, "cuts.csv")
    starts = {(row["mark"], float(row["start"])) for row in cuts}
    bars = [head for head in made.values() if head.bar]
    assert starts == {
        (mark, told.at[0])
        for head in bars for mark, told in zip(marks(head), head.parts, strict=True)
    }  # fmt: skip
    assert len(rows(out, "bars.csv")) == len(bars)
    assert [row["mark"] for row in rows(out, "parts.csv")] == ["B1", "C1", "G1", "S1", "T1"]
    labels = json.loads((out / "labels.json").read_text())["labels"]
    assert Counter((one["mark"], one["program"]) for one in labels) == Counter(
        (mark, name) for name, head in made.items() for mark in marks(head)
    )
    against = [DSTV / "channel.nc1", DSTV / "tie.nc1"]
    call("verify", out / "UPN200_S235JR-1.gcode", "--bar", 4300, "--against", *against, status=0)


def test_a_list_has_the_bars_and_cuts_of_a_batch_over_stock(tmp_path: Path) -> None:
    """With a remnant, two sections and a plate: the same bars, and every piece at its place."""
    folder, out = order(tmp_path / "in"), tmp_path / "out"
    words = ("--bar", 12000, "--remnant", "UPN200/S235JR=4300", "--remnant", "IPE300=5000")
    assert call("batch", folder, *words, "-o", out).exit_code == 0
    listed = json.loads(call("list", folder, *words, "--json").stdout)
    for name, table in (("bars.csv", "bars"), ("cuts.csv", "cutting_list")):
        plain = [{k: str(v) for k, v in row.items() if k != "bar"} for row in listed[table]]
        batch = [{k: v for k, v in row.items() if k != "bar"} for row in rows(out, name)]
        key = "stock" if name == "bars.csv" else "start"
        for row in (*plain, *batch):
            for field in ("stock", "parts", "cuts", "remnant", "used_percent", "length", "start"):
                if field in row:
                    row[field] = f"{float(row[field]):.1f}"
            row.pop("file", None)
        assert sorted(plain, key=lambda r: (r["profile"], r[key])) == sorted(
            batch, key=lambda r: (r["profile"], r[key])
        )
    assert sorted(row["stock"] for row in listed["bars"]) == [4300, 5000, 12000, 12000]
    refused = call("list", folder, "--bar", 12000, "--remnant", 4300)
    assert (refused.exit_code, "error batch-remnant" in refused.stderr) == (1, True)
    alone = call("list", DSTV / "beam.nc1", "--bar", 3000, "--remnant", 4300, "--json")
    assert [row["stock"] for row in json.loads(alone.stdout)["bars"]] == [4300]


def test_labels_of_a_run_over_stock_are_printed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call("batch", order(tmp_path / "in"), "--bar", 12000, "-o", out).exit_code == 0
    assert call("labels", out / "labels.json", "-o", tmp_path / "l.zpl").exit_code == 0
    text = (tmp_path / "l.zpl").read_text()
    assert text.count("^XA") == 6
    assert "UPN200_5FS235JR.gcode" in text
    assert call("labels", out / "labels.json", "-o", tmp_path / "l.pdf").exit_code == 0
    again = call("labels", out / "labels.json", "--json")
    assert again.stdout == (out / "labels.json").read_text()
    for torn in ("", '"labels": 5}'):
        (out / "labels.json").write_text('{"schema": "beamcam/labels/1",' + torn)
        done = call("labels", out / "labels.json", "--json", status=1)
        assert "label-file" in done.stderr
    long = [{"mark": "x" * 3000, "lines": [], "program": "p"}]
    (out / "labels.json").write_text(json.dumps({"schema": "beamcam/labels/1", "labels": long}))
    assert "label-code" in call("labels", out / "labels.json", "--json").stderr


def test_a_page_has_a_setup_sheet_of_each_bar_and_sheet(tmp_path: Path) -> None:
    words = ("--bar", 12000, "-o", tmp_path / "out", "--report", tmp_path / "r.html")
    assert call("batch", order(tmp_path / "in"), *words).exit_code == 0
    pages = {p.name: p.read_text() for p in (tmp_path / "r.sheets").iterdir()}
    assert {name.removesuffix(".html") for name in pages} == {*heads(tmp_path / "out")}
    assert all(mark in pages["UPN200_S235JR.gcode.html"] for mark in ("C1", "T1"))


def test_the_bars_are_those_of_list(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in"), tmp_path / "out"
    for words in ((), ("--turn", "--order", "best")):
        assert call("batch", folder, "--bar", 6500, *words, "-o", out).exit_code == 0
        cuts = tmp_path / "cuts.csv"
        call("list", folder, "--bar", 6500, *words, "-o", cuts, "--table", "cuts", status=0)
        listed = rows(tmp_path, "cuts.csv")
        assert listed
        keys = [key for key in listed[0] if key != "bar"]
        by_name = [sorted([row[key] for key in keys] for row in table)
                   for table in (listed, rows(out, "cuts.csv"))]  # fmt: skip
        assert by_name[0] == by_name[1]


def test_workers_make_the_same(tmp_path: Path) -> None:
    folder = order(tmp_path / "in")
    for jobs in (1, 2):
        words = ("--bar", 12000, "--turn", "--order", "best", "--jobs", jobs)
        assert call("batch", folder, *words, "-o", tmp_path / f"{jobs}").exit_code == 0
    one, two = (
        {p.name: p.read_bytes() for p in (tmp_path / name).iterdir() if p.name[0] != "."}
        for name in "12"
    )
    assert one == two


def test_what_no_machine_makes_stands_in_the_account_and_the_rest_is_made(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in", "channel", "tie"), tmp_path / "out"
    (folder / "bad.nc1").write_text(BAD)
    (folder / "cut.nc1").write_bytes((SAMPLES / "bad" / "cut-denied.nc1").read_bytes())
    done = call("batch", folder, "--bar", 12000, "-o", out, "--json", status=1)
    report = json.loads(done.stdout)
    assert report["counts"] == {"posted": 1, "unchanged": 0, "refused": 2, "failed": 0}
    refused = {
        Path(row["file"]).name: {m["code"] for m in row["messages"] if m["severity"] == "error"}
        for row in report["files"] if row["status"] == "refused"
    }  # fmt: skip
    assert refused["cut.nc1"] == {"dstv-cut-angle"}
    assert "plan-no-machine" in refused["bad.nc1"]
    assert [marks(head) for head in heads(out).values()] == [["C1", "T1", "T1"]]
    not_made = {row["mark"]: row["not_made"] for row in rows(out, "parts.csv")}
    assert not_made["C1"] == not_made["T1"] == ""
    assert not_made["BAD"]


def test_a_part_that_only_a_remnant_holds_leaves_the_others(tmp_path: Path) -> None:
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    for mark, length in (("A", 7000.0), ("B", 7100.0), ("C", 2000.0)):
        (folder / f"{mark}.nc1").write_text(part(mark, length))
    done = call("batch", folder, "--bar", 6000, "--remnant", 8000, "-o", out, status=1)
    assert "B.nc1:1: error plan-bar-full" in done.stderr
    assert sorted((head.bar, marks(head)) for head in heads(out).values()) == [
        (6000.0, ["C"]), (8000.0, ["A"]),
    ]  # fmt: skip


def test_two_parts_of_one_mark_refuse_all_before_anything_is_written(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in", "channel", "tie"), tmp_path / "out"
    text = (DSTV / "channel.nc1").read_text().replace("3000.00", "2990.00")
    (folder / "other.nc1").write_text(text)
    done = call("batch", folder, "--bar", 12000, "-o", out, status=1)
    assert "other.nc1:1: error list-mark-twice" in done.stderr
    assert not [p for p in out.iterdir() if p.name[0] != "."]
    (folder / "other.nc1").write_text(text.replace("\n  DEMO\n", "\n  OTHER\n"))
    assert call("batch", folder, "--bar", 12000, "-o", out).exit_code == 0


def statuses(*words: object) -> dict[str, str]:
    done = call(*words, "--json", status=0)
    return {row["file"]: row["status"] for row in json.loads(done.stdout)["files"]}


def test_only_what_changed_is_made_again(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in"), tmp_path / "out"
    words = ("batch", folder, "--bar", 12000, "-o", out)
    assert {*statuses(*words).values()} == {"posted"}
    assert {*statuses(*words).values()} == {"unchanged"}
    # Another bar in store changes no program that lies on the same bar.
    assert {*statuses(*words, "--remnant", "IPE300=700").values()} == {"unchanged"}
    (out / "IPE160_S235JR.gcode").unlink()  # as after a run that was killed
    tie = folder / "tie.nc1"
    tie.write_text(tie.read_text().replace("  2\n", "  3\n", 1))
    now = statuses(*words)
    assert {name for name, status in now.items() if status == "posted"} == {
        "IPE160_S235JR.gcode", "UPN200_S235JR.gcode",
    }  # fmt: skip


def test_programs_of_an_earlier_run_are_named(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in", "channel", "tie"), tmp_path / "out"
    assert call("batch", folder, "--bar", 12000, "-o", out).exit_code == 0
    done = call("batch", folder, "--bar", 12000, "--remnant", 4300, "-o", out, status=0)
    assert "'UPN200_S235JR.gcode' still stands from an earlier run over stock" in done.stderr


def test_the_pieces_of_all_programs_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shares_of = over_stock.shares_of
    monkeypatch.setattr(over_stock, "shares_of", lambda request: shares_of(request)[:-1])
    folder = order(tmp_path / "in", "channel", "tie")
    done = call("batch", folder, "--bar", 3500, "-o", tmp_path / "out", status=1)
    assert "error verify-pieces: found" in done.stderr
    assert not heads(tmp_path / "out")


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (("--remnant", "4300"), 1, "error batch-remnant: found the remnant 4300; expected "),
        (("--remnant", "x=4300", "--each"), 2, "found --each with --remnant"),
        (("--remnant", "UPN200="), 2, "found 'UPN200='; expected a length above 0"),
        (("--remnant", "-5"), 2, "found '-5'; expected a length above 0"),
        (("--nest", "--name", "{mark}.gcode"), 2, "found --name over stock"),
        (("--nest", "--tree"), 2, "found --tree over stock"),
        (("--remnant", "UPN 200 / s235jr=4300"), 0, "posted"),
    ],
)
def test_remnants_and_names_that_cannot_be_meant(
    tmp_path: Path, words: tuple[str, ...], status: int, said: str
) -> None:
    done = call("batch", order(tmp_path / "in", "channel", "beam"), *words, "-o", tmp_path / "out")
    assert done.exit_code == status, done.stderr
    assert said in " ".join(done.stderr.split())


def test_each_part_by_itself_where_that_is_asked_for(tmp_path: Path) -> None:
    folder = order(tmp_path / "in", "channel", "tie")
    for words in ((), ("--each", "--bar", "12000")):
        out = tmp_path / f"out{len(words)}"
        assert call("batch", folder, *words, "-o", out).exit_code == 0
        assert [*heads(out)] == ["channel.gcode", "tie.gcode"]


def test_a_file_of_somebody_else_is_not_written_over(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in", "channel"), tmp_path / "out"
    out.mkdir()
    (out / "parts.csv").write_text("mine\n")
    done = call("batch", folder, "--nest", "-o", out, status=1)
    assert "error batch-not-ours: found 'parts.csv' there already" in done.stderr
    assert (out / "parts.csv").read_text() == "mine\n"
    assert call("batch", folder, "--nest", "--force", "-o", out).exit_code == 0
    assert rows(out, "parts.csv")
    assert call("batch", folder, "--nest", "-o", out).exit_code == 0


def test_check_posts_a_run_over_stock_again(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in"), tmp_path / "out"
    assert call("batch", folder, "--bar", 12000, "-o", out).exit_code == 0
    done = call("check", out)
    assert (done.exit_code, done.stdout) == (0, "4 of 4 programs are the same\n")
    tie = folder / "tie.nc1"
    tie.write_text(tie.read_text().replace("320.00", "330.00"))
    done = call("check", out, status=1)
    assert "3 of 4 programs are the same" in done.stdout
    assert call("check", out, "--update").exit_code == 0
    assert call("check", out).exit_code == 0
    assert {*statuses("batch", folder, "--bar", 12000, "-o", out).values()} <= {
        "unchanged", "posted",
    }  # fmt: skip
    (folder / "strut.nc1").unlink()
    done = call("check", out, status=1)
    assert "strut.nc1: error read-file" in done.stderr


def test_a_dry_run_writes_nothing(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = call("batch", order(tmp_path / "in"), "--bar", 12000, "-o", out, "--dry-run", status=0)
    assert "UPN200_S235JR.gcode, beamline" in done.stdout
    assert not out.exists()


def test_a_worker_that_dies_fails_its_program_alone(tmp_path: Path) -> None:
    """The results of workers in any order, one of whose tasks is lost and one deadly."""

    class Workers:
        most_files = at_once = 2

        def __init__(self) -> None:
            self.chunks: list[Any] = []
            self.seen: Counter[int] = Counter()

        def has_room(self) -> bool:
            return len(self.chunks) < 2

        def submit(self, chunk: Any) -> None:
            self.chunks.append(chunk)

        def wait(self) -> Any:
            chunk = self.chunks.pop()
            self.seen.update(task.index for task in chunk)
            if any(task.index == 1 for task in chunk):
                yield chunk, Died()
            elif any(task.index == 2 and self.seen[2] == 1 for task in chunk):
                yield chunk, None
            else:
                yield chunk, [made(task) for task in chunk]

    def made(task: Any) -> work.FileResult:
        row: Any = {"file": task.name, "status": "posted", "format": "", "seconds": 0.0,
                    "parts": [], "messages": []}  # fmt: skip
        return work.FileResult(task.index, row)

    tasks = (FileState(k, f"{k}.nc1", b"") for k in range(5))
    found = {one.index: one.row["status"] for one in driven(Workers(), tasks, NEVER)}
    assert found == {0: "posted", 1: "failed", 2: "posted", 3: "posted", 4: "posted"}


# --- marks in a batch of single parts -------------------------------------------------------------


def test_a_mark_of_an_order_is_one_part_in_every_batch(tmp_path: Path) -> None:
    folder, out = order(tmp_path / "in", "channel", "tie"), tmp_path / "out"
    channel = (folder / "channel.nc1").read_text()
    (folder / "copy.nc1").write_text(channel)  # the same part twice is no fault
    (folder / "other.nc1").write_text(channel.replace("3000.00", "2990.00"))
    (folder / "phase.nc1").write_text(
        channel.replace("3000.00", "2980.00").replace("  1\n  C1", "  2\n  C1", 1)
    )
    for again in range(2):
        done = call("batch", folder, "-o", out, "--json", status=1)
        found = {Path(row["file"]).name: row for row in json.loads(done.stdout)["files"]}
        refused = {name for name, row in found.items() if row["status"] == "refused"}
        assert refused == {"channel.nc1", "copy.nc1", "other.nc1"}, again
        for name in refused:
            (said,) = (m for m in found[name]["messages"] if m["severity"] == "error")
            assert said["code"] == "list-mark-twice"
            assert ("channel.nc1" if name == "other.nc1" else "other.nc1") in said["message"]
        assert {*heads(out)} == {"phase.gcode", "tie.gcode"}
    assert call("batch", folder, "-o", tmp_path / "2", "--mark-from", "file").exit_code == 0


def test_what_differs_under_one_mark_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    """The first of both would stand in the shop's folder when the second is met."""
    folder, out = order(tmp_path / "in", "channel"), tmp_path / "out"
    text = (folder / "channel.nc1").read_text()
    (folder / "zz.nc1").write_text("** a comment\n" + text.replace("3000.00", "2990.00"))
    assert call("batch", folder, "-o", out).exit_code == 1
    assert heads(out) == {}
    (folder / "zz.nc1").unlink()
    assert call("batch", folder, "-o", out).exit_code == 0


def test_a_file_with_two_parts_of_one_mark_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A member that is in a model twice is one part; of two that differ the later is refused."""
    one = read_file(str(DSTV / "channel.nc1")).parts[0]
    other = replace(one, length=2990.0, features=(), source=replace(one.source, line=9))
    (tmp_path / "model.ifc").write_text("")
    for parts, status in (((one, one), 0), ((one, other), 1)):
        reading = Reading("ifc", parts, ())
        monkeypatch.setattr(work, "read", lambda *_, reading=reading, **__: reading)
        done = call("batch", tmp_path / "model.ifc", "-o", tmp_path / f"out{status}", "--jobs", 1)
        assert done.exit_code == status, done.stderr
        assert ("list-mark-twice" in done.stderr) == bool(status)
        assert len(heads(tmp_path / f"out{status}")) == 1  # equal members are one part


def test_marks_are_kept_over_the_runs_of_a_watch(tmp_path: Path) -> None:
    """Files that come one after the other are parts of one order all the same."""
    folder = order(tmp_path / "in", "channel")
    text = (folder / "channel.nc1").read_text().replace("3000.00", "2990.00")
    (folder / "later.nc1").write_text(text)
    shop, known = BatchSettings(Request((), load("beamline"))), dict[Any, str]()
    found = []
    for name in ("channel.nc1", "later.nc1"):
        inputs = [Input(str(folder / name), name)]
        found += run_files(inputs, RunSetup(str(tmp_path / "out"), shop, Here(shop)), marks=known)
    assert [row["status"] for row in found] == ["posted", "refused"]
    assert [m["code"] for m in found[1]["messages"]] == ["list-mark-twice"]
    assert [*heads(tmp_path / "out")] == ["channel.gcode"]


# --- copers ---------------------------------------------------------------------------------------


def test_pieces_of_a_coper_are_cut_from_a_bar_each(tmp_path: Path) -> None:
    """Trims of 30 mm at both ends by the machine's file: 1260 of each bar, 860 of the channel's."""
    coping, out = SAMPLES / "coping", tmp_path / "out"
    words = ("--machine", "coper-linuxcnc", "--bar", 6000, "--quantity", 2)
    inputs = (coping / "coped.nc1", coping / "trimmer.nc1")
    assert call("batch", *inputs, "-o", out, *words).exit_code == 0
    listed = json.loads(call("list", *inputs, *words, "--json").stdout)
    assert [
        (bar["profile"], bar["stock"], bar["parts"], bar["cuts"], bar["remnant"])
        for bar in listed["bars"]
    ] == [("IPE300", 6000, 1200, 60, 4740)] * 2 + [("UPN200", 6000, 800, 60, 5140)] * 2
    assert [(row["mark"], row["start"]) for row in listed["cutting_list"]] == [
        ("C1", 30), ("C1", 30), ("C2", 30), ("C2", 30),
    ]  # fmt: skip
    bars = (out / "bars.csv").read_text().splitlines()
    assert bars[1] == "1,IPE300,S235JR,coper-linuxcnc,6000.0,1,1200.0,60.0,4740.0,20.0"
    assert len(bars) == len((out / "cuts.csv").read_text().splitlines()) == 5
    assert call("check", out).exit_code == 0


def test_a_coper_has_a_program_for_each_piece(tmp_path: Path) -> None:
    words = ("--machine", "coper-linuxcnc", "--quantity", 2)
    call("post", SAMPLES / "coping" / "coped.nc1", "-o", tmp_path / "a.ngc", *words, status=0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a-1.ngc", "a-2.ngc"]
    short = call(
        "post", SAMPLES / "coping" / "coped.nc1", "-o", tmp_path / "b.ngc", *words, "--bar", 1259
    )
    assert "plan-bar-full" in short.stderr
