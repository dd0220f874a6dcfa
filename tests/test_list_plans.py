"""Lists and labels are those of the plans that `post` makes: starts, machines, weights, marks."""

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam import api
from beamcam.checks.bars import run as read_bar
from beamcam.checks.bars.pieces import pieces as pieces_between
from beamcam.checks.bars.pieces import planes
from beamcam.cli import main
from beamcam.errors import Source
from beamcam.machine import Machine, load
from beamcam.model.part import Part
from beamcam.model.request import numbered
from beamcam.model.section import corners
from beamcam.pipeline import read_file
from beamcam.reports.part_list import Weights, weights_of
from beamcam.solid.kernel import outline
from beamcam.solid.part_solid import part_solid
from tests.conftest import CORPUS, examples, sampled
from tests.random_copes import random_cope, random_mitre, random_tee
from tests.runs import call
from tests.runs import part as part_text
from tests.test_lists import BEAM, SAMPLES, lists

THIRD = pytest.mark.third_party


def test_what_no_machine_makes_stands_in_red_with_its_reason_and_on_no_bar(tmp_path: Path) -> None:
    found = lists(tmp_path, str(SAMPLES), "--bar", "12000", status=1)
    why = {row["mark"]: row["not_made"] for row in found["part_list"] if row["not_made"]}
    assert why.keys() == {"Z1"}
    assert why["Z1"].startswith("plan-stock: found a part of profile code SO")
    assert {row["machine"] for row in found["part_list"] if row["mark"] in why} == {None}
    assert not why.keys() & {row["mark"] for row in found["cutting_list"]}
    few = [str(SAMPLES / f"{name}.nc1") for name in ("tie", "purlin", "gusset")]
    assert call("list", *few, "-o", str(tmp_path / "l.xlsx")).exit_code == 1
    sheet = openpyxl.load_workbook(tmp_path / "l.xlsx")["part list"]
    red = {
        row[0].value
        for row in sheet.iter_rows()
        if row[0].font.color and row[0].font.color.rgb == "FFC00000"
    }
    assert red == why.keys()
    shown = CliRunner(env={"FORCE_COLOR": "1"}).invoke(main, ["list", *few], color=True)
    marked = {line.split()[1] for line in shown.stdout.splitlines() if "\x1b[31m" in line}
    assert marked == why.keys()
    done = call("list", *few)
    assert (done.exit_code, done.stderr.count("error plan-no-machine")) == (1, 1)


def test_a_bar_that_post_refuses_is_not_listed(tmp_path: Path) -> None:
    """18 m are more than the pusher's line takes: `post` and the list say the same."""
    words = (str(SAMPLES / "channel.nc1"), "--machine", "beamline-pusher", "--bar", "18000")
    found = lists(tmp_path, *words, status=1)
    posted = call("post", *words, "--quantity", "file", "-o", str(tmp_path / "c.gcode"))
    assert posted.exit_code == 1
    assert (found["bars"], found["cutting_list"]) == ([], [])
    code = re.findall("error (plan-[a-z-]+)", posted.stderr)[0]
    assert found["part_list"][0]["not_made"].startswith(f"{code}: ")


def starts_made(program: Path, part: Part, machine: Machine) -> list[float]:
    """Where each piece begins on its bar, by the cuts that a program makes and nothing else."""
    saw = machine.saw
    assert saw is not None
    done = read_bar(program.read_text("ascii"), machine, part.profile, program.name)
    lift = part.profile.height if saw.pivot == "o" else 0.0
    section = corners(part.profile, part.section)
    return [
        min(piece.start.along(y - lift, z) for y, z in section) + piece.start.half_kerf
        for piece in pieces_between(planes(done.made.cuts, saw, part.profile))
        if piece.end.cut.x - piece.start.cut.x > 0.6 * part.length  # no wedge between two mitres
    ]


@pytest.mark.parametrize("machine", sampled(["beamline-pusher", "beamline"], 2))
@pytest.mark.parametrize("folder", [SAMPLES, pytest.param(CORPUS / "dstv", marks=THIRD)])
def test_every_start_is_the_programs(folder: Path, machine: str, tmp_path: Path) -> None:
    """Each part three times on bars of 12 m: listed, and found in what its programs cut."""
    words = ("--machine", machine, "--bar", "12000", "--quantity", "3", "--allow-skips", "all")
    seen = 0
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() in (".nc", ".nc1")):
        (part, *_) = read_file(str(path)).parts or (None,)
        if part is None or part.profile.code == "B":
            continue
        listed: dict[int, list[float]] = {}
        for row in json.loads(call("list", str(path), *words, "--json").stdout or "{}").get(
            "cutting_list", ()
        ):
            listed.setdefault(row["bar"], []).append(row["start"])
        job = tmp_path / f"{path.stem}.gcode"
        posted = call("post", str(path), *words, "-o", str(job))
        assert bool(listed) == (posted.exit_code == 0), path
        names = numbered(str(job), len(listed))
        for name, starts in zip(names, listed.values(), strict=True):
            made = starts_made(Path(name), part, load(machine))
            assert starts == pytest.approx(made, abs=0.02), path
            seen += len(made)
    assert seen >= 9


@pytest.mark.parametrize("folder", [SAMPLES, pytest.param(CORPUS / "dstv", marks=THIRD)])
def test_every_weight_is_the_solids(folder: Path) -> None:
    """Within 1 %, of parts that the geometry kernel can build."""
    seen = 0
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() in (".nc", ".nc1")):
        for part in read_file(str(path)).parts:
            finished = weights_of(part).finished
            if any(feature.face.startswith("E") for feature in (*part.holes, *part.slots)):
                continue  # on a plane of its own, of which no solid is known
            volume = part_solid(part).volume()
            if part.profile.code == "C":  # whose solid has no lips: what they weigh by the header
                volume += part.length * (part.weight / 7.85e-3 - outline(part).area)
            assert finished == pytest.approx(volume * 7850e-9, rel=0.01), path
            seen += 1
    assert seen >= 10


@given(st.integers(0, 3000), st.sampled_from([random_cope, random_mitre, random_tee]))
@settings(max_examples=examples(20), deadline=None)
def test_holes_beside_cuts_weigh_what_the_solid_says(
    seed: int, random_part: Callable[[int], Part]
) -> None:
    part = random_part(seed)
    finished = weights_of(part).finished
    assert finished == pytest.approx(part_solid(part).volume() * 7850e-9, rel=0.001)


def test_an_outline_on_both_faces_weighs_once(tmp_path: Path) -> None:
    """FL100x10x2500: 0.1 x 0.01 x 2.5 m of steel are 19.625 kg, as its header's 78.5 kg/m2 say."""
    places = ("0.00u 0.00", "2500.00 0.00", "2500.00 100.00", "0.00 100.00", "0.00 0.00")
    rows = "".join(f"    {place} 0.00\n" for place in places)
    outline = "".join(f"AK\n  {face} {rows.lstrip()}" for face in "vh")
    values = ("O", "1", "1", "FL", "S235JR", "1", "FL100X10", "B", "2500.00", "100.00", "0.00",
              "0.00", "10.00", "0.00", "{weight}", *("0.000",) * 5, *("",) * 4)  # fmt: skip
    head = "ST\n" + "".join(f"  {value}\n" for value in values)
    (tmp_path / "fl.nc1").write_text(head.format(weight="78.500") + outline + "EN\n")
    (row,) = lists(tmp_path, str(tmp_path / "fl.nc1"))["part_list"]
    assert (row["weight_kg"], row["gross_kg"], row["header_kg"]) == (19.625, 19.625, None)
    (tmp_path / "fl.nc1").write_text(head.format(weight="70.000") + outline + "EN\n")
    (row,) = lists(tmp_path, str(tmp_path / "fl.nc1"))["part_list"]
    assert (row["weight_kg"], row["header_kg"]) == (19.625, 17.5)


def test_weights_of_catalogue_and_header_stand_beside_ours_where_they_differ() -> None:
    """IPE200: 28.48 cm2 and 22.4 kg/m by EN 10365."""
    thin = replace(BEAM, web_thickness=3.0)
    part = Part("B", thin, 1000.0, Source("test"), weight=22.4)
    weights = weights_of(part)
    assert weights.gross == pytest.approx((28.48 - 18.3 * 0.26) * 0.785, rel=0.002)
    assert (weights.catalogue, weights.header) == (pytest.approx(22.36, abs=0.05), 22.4)
    assert weights_of(replace(part, profile=BEAM)) == Weights(
        pytest.approx(22.36, abs=0.05), pytest.approx(22.36, abs=0.05)
    )


def test_lists_and_labels_as_json(tmp_path: Path) -> None:
    tie = str(SAMPLES / "tie.nc1")
    assert call("list", tie, "--json").stdout == call("list", tie, "--to", "json").stdout
    assert json.loads(call("list", tie, "--json").stdout)["schema"] == "beamcam/list/1"
    found = json.loads(call("labels", tie, "--json").stdout)
    assert found["schema"] == "beamcam/labels/1"
    assert [one["code"] for one in found["labels"]] == ["T1\ntie.gcode"] * 2
    assert found["labels"][1]["lines"][1] == "S235JR, piece 2 of 2"
    assert call("labels", tie, "--to", "zpl", "-o", "-").stdout.count("^XA") == 2
    both = call("list", tie, "--json", "--to", "csv")
    assert (both.exit_code, "exclude each other" in both.stderr) == (2, True)


def test_a_label_names_the_program_that_makes_its_piece(tmp_path: Path) -> None:
    """Those that a batch writes: of three bars, and of the machine that makes the part."""
    words = (str(SAMPLES / "channel.nc1"), str(SAMPLES / "plate.nc1"), "--quantity", "3",
             "--bar", "6000")  # fmt: skip
    labels = json.loads(call("labels", *words, "--json").stdout)["labels"]
    done = call("batch", *words, "--each", "-o", str(tmp_path), "--json")
    pieces = [
        (part["mark"], part["output"])
        for row in json.loads(done.stdout)["files"]
        for part in row["parts"]
        for _ in range(part["pieces"])
    ]
    assert [(one["mark"], one["program"]) for one in labels] == pieces
    assert {name for _, name in pieces} >= {"channel-1.gcode", "channel-3.gcode"}


@pytest.mark.parametrize(("source", "marks"), [
    ("mark", ["991", "991"]), ("drawing", ["D1", "D2"]), ("file", ["one", "two"]),
    ("position", ["P7", "P8"]),
])  # fmt: skip
def test_where_the_marks_stand(source: str, marks: list[str], tmp_path: Path) -> None:
    """Two parts that both read 991: refused by their mark, told apart by anything else."""
    for name, drawing, phase, length in (("one", "D1", "P7", 2000.0), ("two", "D2", "P8", 2100.0)):
        text = part_text("991", length).replace("\n  1\n  1\n", f"\n  {drawing}\n  PHASE\n", 1)
        text = text.replace("PHASE", phase if source == "position" else "1")
        (tmp_path / f"{name}.nc1").write_text(text, encoding="ascii")
    words = (str(tmp_path / "one.nc1"), str(tmp_path / "two.nc1"), "--mark-from", source)
    done = call("list", *words, "-o", str(tmp_path / "l.csv"))
    if source == "mark":
        assert (done.exit_code, done.stderr.count("list-mark-twice")) == (1, 1)
        assert not (tmp_path / "l.csv").exists()  # refused before anything is written
        return
    assert done.exit_code == 0, done.stderr
    with (tmp_path / "l.csv").open(encoding="utf-8") as file:
        assert [row["mark"] for row in csv.DictReader(file)] == marks
    out = tmp_path / "out"
    named = call("batch", *words, "-o", str(out), "--name", "{mark}{suffix}")
    assert named.exit_code == 0, named.stderr
    assert sorted(path.stem for path in out.glob("*.gcode")) == marks
    assert [part.mark for part in api.read(words[0], mark_from=source).parts] == marks[:1]  # type: ignore[arg-type]


@pytest.mark.parametrize(("order", "phase", "mixed"), [
    ("TEST", "1", True), ("OTHER", "1", False), ("TEST", "2", False),
])  # fmt: skip
def test_a_mark_is_one_part_of_its_order_and_phase(
    order: str, phase: str, mixed: bool, tmp_path: Path
) -> None:
    (tmp_path / "a.nc1").write_text(part_text("A", 2000.0), encoding="ascii")
    other = part_text("A", 2100.0).replace("\n  TEST\n  1\n  1\n", f"\n  {order}\n  1\n  {phase}\n")
    (tmp_path / "b.nc1").write_text(other, encoding="ascii")
    done = call("list", str(tmp_path))
    assert (done.exit_code, "list-mark-twice" in done.stderr) == (int(mixed), mixed)


def test_a_batch_turns_parts_as_post_and_list_do(tmp_path: Path) -> None:
    """A blind hole from behind, which only a turned part has in front of a spindle."""
    text = part_text("A").replace("UPN200\n  U", "IPE200\n  I")
    text = text.replace("  v  100.00u   60.00    18.00", "  h  100.00u   60.00    18.00    3.00")
    path = tmp_path / "A.nc1"
    path.write_text(text, encoding="ascii")
    words = (str(path), "--machine", "beamline")
    out = tmp_path / "out"
    refused = call("batch", *words, "-o", str(out))
    assert (refused.exit_code, "plan-face" in refused.stderr) == (1, True)
    assert call("batch", *words, "--turn", "-o", str(out)).exit_code == 0
    assert call("post", *words, "--turn", "-o", str(tmp_path / "a.gcode")).exit_code == 0
    assert (out / "A.gcode").read_bytes() == (tmp_path / "a.gcode").read_bytes()
    assert call("check", str(out)).exit_code == 0
    (piece,) = lists(tmp_path, *words, "--turn")["cutting_list"]
    assert piece["turn"] == "turned 180 about its length"
