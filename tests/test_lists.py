"""Part lists, cutting lists and labels, read back by others: openpyxl, csv, a scanner of codes."""

import csv
import io
import json
import re
from collections import Counter
from hashlib import sha256
from pathlib import Path
from typing import Any

import openpyxl
import pypdfium2
import pytest
import zxingcpp
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.model.part import Part, Profile
from beamcam.plain_text import harmless_cell
from beamcam.planning.manual_list import HEAD as HAND_HEAD
from beamcam.planning.manual_list import as_csv as hand_csv
from beamcam.planning.stock import first_fit
from beamcam.reports.labels import Label, LabelSize, as_pdf, as_zpl, code_rows
from beamcam.reports.tables import Table, as_csv, as_xlsx
from tests.conftest import ROOT, examples
from tests.runs import call

SAMPLES = ROOT / "samples" / "dstv"
MACHINE = load("beamline")
BEAM = Profile("I", "IPE200", 200, 100, 8.5, 5.6, 12)
FLAT = Profile("I", "IPE160", 160, 82, 7.4, 5, 9)


def lists(folder: Path, *words: str, status: int = 0) -> dict[str, list[dict[str, Any]]]:
    done = call("list", *words, "-o", folder / "list.json")
    assert done.exit_code == status, done.stderr
    text = (folder / "list.json").read_text(encoding="utf-8")
    found: dict[str, list[dict[str, Any]]] = json.loads(text)
    return found


def test_a_folder_is_listed_with_all_its_pieces(tmp_path: Path) -> None:
    found = lists(tmp_path, str(SAMPLES), "--bar", "6000", "--bar", "12000", status=1)
    pieces = {row["mark"]: row["quantity"] for row in found["part_list"]}
    assert pieces == {"B1": 1, "BP1": 2, "C1": 1, "G1": 1, "PL1": 4, "Z1": 6, "S1": 1, "T1": 2,
                      "TU1": 1, "L-7": 1, "B-12": 2, "T7": 2, "P4": 2, "FM1": 2, "FL1": 6,
                      "BV1": 1}  # fmt: skip
    assert sum(row["gross_kg"] * row["quantity"] for row in found["part_list"]) == pytest.approx(
        582.841 + 2 * (29.570 + 3.2 * 5.733) + 2 * 41.357 + 6 * 2.904 + 11.775, abs=0.01
    )
    cut = Counter(row["mark"] for row in found["cutting_list"])
    assert cut == {"B1": 1, "C1": 1, "S1": 1, "T1": 2, "B-12": 2, "T7": 2, "P4": 2,
                   "FM1": 2, "TU1": 1}  # fmt: skip
    assert {row["stock"] for row in found["bars"]} == {6000, 12000}
    of = {row["profile"]: row["machine"] for row in found["bars"]}  # the cell takes no T and no C
    pusher = ("1/2 IPE300", "C200*70*20*2", "IPE180")
    assert {of.pop(name) for name in pusher} == {"beamline-pusher"}
    assert of.pop("RHS120*80*5") == "tube-linuxcnc"
    assert {*of.values()} == {"beamline"}


def test_what_is_left_to_the_hand_is_a_column_of_every_form(tmp_path: Path) -> None:
    """Marks and bevels, as the lists beside the programs have them; empty where none makes it."""
    inputs = [str(SAMPLES / f"{name}.nc1") for name in ("marked", "plate", "lettered", "purlin")]
    wanted: dict[str, list[int | None]] = {
        "B-12": [3, 0], "PL1": [0, 1], "L-7": [0, 0], "Z1": [None, None],
    }  # fmt: skip
    columns = ("marks_by_hand", "bevels_by_hand")
    rows = lists(tmp_path, *inputs, status=1)["part_list"]
    assert {row["mark"]: [row[name] for name in columns] for row in rows} == wanted
    assert call("list", *inputs, "-o", tmp_path / "l.csv").exit_code == 1
    with (tmp_path / "l.csv").open(encoding="utf-8") as file:
        told = {row["mark"]: [row[name] for name in columns] for row in csv.DictReader(file)}
    as_text = {mark: ["" if n is None else str(n) for n in row] for mark, row in wanted.items()}
    assert told == as_text
    assert call("list", *inputs, "-o", tmp_path / "l.xlsx").exit_code == 1
    head, *cells = openpyxl.load_workbook(tmp_path / "l.xlsx")["part list"].values
    at = [head.index(name) for name in columns]
    assert {row[0]: [row[k] for k in at] for row in cells} == wanted
    line = next(line for line in call("list", *inputs).stdout.splitlines() if "PL1" in line)
    assert re.search(r" 4 +0 +1 +DEMO", line)
    program = str(tmp_path / "marked.gcode")
    assert call("post", inputs[0], "-o", program).exit_code == 0
    beside = Path(program + ".hand.csv").read_text(encoding="utf-8").splitlines()
    assert len(beside) - 1 == 3


def test_a_number_of_pieces_for_each(tmp_path: Path) -> None:
    found = lists(tmp_path, str(SAMPLES / "tie.nc1"), "--quantity", "40", "--bar", "6000")
    assert [row["pieces"] for row in found["bars"]] == [15, 15, 10]


@pytest.mark.parametrize("words", [
    ("--quantity", "0"), ("--quantity", "many"), ("--quantity", "1000000"),
])  # fmt: skip
def test_a_number_that_cannot_be_meant(words: tuple[str, ...]) -> None:
    done = call("list", SAMPLES / "tie.nc1", *words)
    assert (done.exit_code, "expected file, or 1 to 100000" in done.stderr) == (2, True)


parts = st.builds(
    lambda number, length, profile, grade: Part(
        f"P{number}", profile, float(length), Source("test"), grade=grade
    ),
    st.integers(1, 99), st.integers(300, 5900), st.sampled_from((BEAM, FLAT)),
    st.sampled_from(("S235", "S355")),
)  # fmt: skip


@settings(deadline=None, max_examples=examples(60))
@given(st.lists(st.tuples(parts, st.integers(1, 6)), min_size=1, max_size=8))
def test_each_piece_lies_on_one_bar_and_no_two_overlap(wanted: list[tuple[Part, int]]) -> None:
    pieces = [part for part, count in wanted for _ in range(count)]
    nesting = first_fit(pieces, MACHINE, (6000.0, 12000.0))
    assert not nesting.refusals
    assert sorted(i for bar in nesting.bars for i in bar.pieces) == list(range(len(pieces)))
    for bar in nesting.bars:
        on_bar = [pieces[i] for i in bar.pieces]
        assert len({(p.profile, p.grade) for p in on_bar}) == 1
        assert bar.account.length in (6000.0, 12000.0)
        ends = [start + part.length for start, part in zip(bar.starts, on_bar, strict=True)]
        assert MACHINE.saw is not None
        for end, start in zip(ends, bar.starts[1:], strict=False):
            assert start >= end + MACHINE.saw.kerf - 1e-9
        assert ends[-1] + MACHINE.saw.kerf <= bar.account.length
    by_section = Counter((p.profile, p.grade) for p in pieces)
    bars = Counter((pieces[b.pieces[0]].profile, pieces[b.pieces[0]].grade) for b in nesting.bars)
    for key in by_section:  # two bars less than half full would have been one
        needed = sum(p.length for p in pieces if (p.profile, p.grade) == key)
        assert bars[key] <= max(1, 2 * needed / 11_500 + 1)


def test_a_part_that_fits_on_no_bar_is_told_once() -> None:
    done = call("list", SAMPLES / "beam.nc1", "--bar", "4000", "--quantity", "3", status=1)
    assert done.stderr.count("error plan-bar-full") == 1
    assert "B1" in done.stdout


def test_two_contents_under_one_mark(tmp_path: Path) -> None:
    text = (SAMPLES / "tie.nc1").read_text("ascii")
    (tmp_path / "a.nc1").write_text(text, "ascii")
    (tmp_path / "same.nc1").write_text(text.replace("DEMO", "OTHER"), "ascii")
    assert "list-mark-twice" not in call("list", tmp_path).stderr
    (tmp_path / "b.nc1").write_text(text.replace("60.00  18.00", "60.00  22.00", 1), "ascii")
    if text.count("60.00  18.00") == 0:
        changed = re.sub(r"(v +40\.00u +60\.00 +)18\.00", r"\g<1>22.00", text, count=1)
        assert changed != text
        (tmp_path / "b.nc1").write_text(changed, "ascii")
    done = call("list", tmp_path, status=1)
    assert done.stderr.count("list-mark-twice") == 1
    assert "b.nc1" in done.stderr


def test_a_file_that_is_refused_leaves_the_others(tmp_path: Path) -> None:
    done = call("list", SAMPLES / "tie.nc1", ROOT / "samples" / "bad" / "empty.nc1", status=1)
    assert "T1" in done.stdout
    assert "empty.nc1" in done.stderr


def _plain(cell: object) -> object:
    """A cell without its type: CSV has texts only."""
    try:
        return float(str(cell))
    except ValueError:
        return cell or None


def test_the_forms_agree(tmp_path: Path) -> None:
    inputs = [SAMPLES / f"{name}.nc1" for name in ("channel", "plate", "purlin", "tie")]
    for name in ("list.csv", "list.xlsx", "list.txt"):
        words = ("list", *inputs, "--bar", "6000", "--bar", "12000", "-o")
        assert call(*words, tmp_path / name).exit_code == 1
    rows = list(csv.reader((tmp_path / "list.csv").open(encoding="utf-8", newline="")))
    book = openpyxl.load_workbook(tmp_path / "list.xlsx")
    assert book.sheetnames == ["part list", "bars", "cutting list"]
    sheet = [[_plain(cell) for cell in row] for row in book["part list"].values]
    assert [[_plain(cell) for cell in row] for row in rows] == sheet
    first = (tmp_path / "list.xlsx").read_bytes()
    assert call(*words, tmp_path / "again.xlsx").exit_code == 1
    assert (tmp_path / "again.xlsx").read_bytes() == first


def test_a_text_is_no_formula() -> None:
    table = Table("part list", ("mark",), (("=1+1",), ("-a",)), (None,))
    assert as_csv(table) == "mark\n'=1+1\n'-a\n"
    book = openpyxl.load_workbook(io.BytesIO(as_xlsx([table])))
    cells = [(c.value, c.data_type) for c in book["part list"]["A"][1:]]
    assert cells == [("=1+1", "s"), ("-a", "s")]


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    for command, name in (("list", "list.pdf"), ("labels", "labels.png")):
        done = call(command, SAMPLES / "tie.nc1", "-o", tmp_path / name)
        assert (done.exit_code, "write-format" in done.stderr) == (1, True)
    assert not list(tmp_path.iterdir())


def test_labels_are_read_by_a_scanner(tmp_path: Path) -> None:
    """A page for each piece; its code has the mark and what a batch calls the program."""
    output = tmp_path / "labels.pdf"
    done = call("labels", SAMPLES, "-o", output)
    assert (done.exit_code, done.stderr.count("error plan-no-machine")) == (1, 1)
    pages = pypdfium2.PdfDocument(output)
    read = [zxingcpp.read_barcode(page.render(scale=3).to_pil()) for page in pages]
    codes = [code.text for code in read if code is not None]
    assert len(codes) == len(pages) == 35 - 6  # of one part no machine makes
    programs = dict(code.split("\n") for code in codes)
    assert programs["B1"] == "beam.gcode"
    assert programs["PL1"].startswith("plate.")
    assert Counter(code.split("\n")[0] for code in codes)["PL1"] == 4
    text = pages[0].get_textpage().get_text_range()
    assert "B1" in text
    assert "IPE300, 4200 mm" in text
    again = tmp_path / "again.pdf"
    assert call("labels", SAMPLES, "-o", again).exit_code == 1
    assert again.read_bytes() == output.read_bytes()


@settings(deadline=None, max_examples=examples(15))
@given(
    st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=40),
    st.sampled_from((LabelSize(), LabelSize(60, 30), LabelSize(50, 80), LabelSize(40, 25))),
)
def test_any_mark_is_read_back(mark: str, size: LabelSize) -> None:
    label = Label(mark, ("IPE200  L 1000 mm", "S235  1 / 1"), "p.gcode")
    page = pypdfium2.PdfDocument(as_pdf([label], size))[0]
    assert page.get_size() == pytest.approx((size.width * 72 / 25.4, size.height * 72 / 25.4))
    found = zxingcpp.read_barcode(page.render(scale=5).to_pil())
    assert found is not None
    assert found.text == label.code


@settings(deadline=None, max_examples=examples(10))
@given(
    st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=200)
)
def test_any_mark_is_read_back_as_a_datamatrix(mark: str) -> None:
    label = Label(mark, ("IPE200  L 1000 mm",), "p.gcode")
    page = pypdfium2.PdfDocument(as_pdf([label], LabelSize(), "datamatrix"))[0]
    found = zxingcpp.read_barcode(page.render(scale=5).to_pil())
    assert found is not None
    assert (found.text, found.format) == (label.code, zxingcpp.BarcodeFormat.DataMatrix)


def test_labels_take_the_code_that_is_asked_for(tmp_path: Path) -> None:
    words = ("labels", str(SAMPLES / "tie.nc1"), "--quantity", "1", "--code", "datamatrix")
    assert call(*words, "-o", tmp_path / "l.pdf").exit_code == 0
    page = pypdfium2.PdfDocument(tmp_path / "l.pdf")[0]
    found = zxingcpp.read_barcode(page.render(scale=3).to_pil())
    assert found is not None
    assert (found.text, found.format) == (
        "T1\ntie.gcode", zxingcpp.BarcodeFormat.DataMatrix,
    )  # fmt: skip
    assert call(*words, "-o", tmp_path / "l.zpl").exit_code == 0
    assert "^BXN,12,200,,,6,~^FH^FDT1_0Atie.gcode^FS" in (tmp_path / "l.zpl").read_text("ascii")


@given(st.lists(st.text(max_size=30), min_size=1, max_size=4))
def test_zpl_holds_the_texts_and_nothing_that_the_printer_obeys(texts: list[str]) -> None:
    label = Label(texts[0], tuple(texts), "p.gcode")
    text = as_zpl([label], LabelSize())
    assert text.isascii()
    body, mark = text.split("^FD"), label.code
    fields = [part.split("^FS")[0] for part in body[1:]]
    plain = [
        re.sub(r"((?:_[0-9A-F]{2})+)",
               lambda m: bytes.fromhex(m[1].replace("_", "")).decode("utf-8"), field)
        for field in fields
    ]  # fmt: skip
    assert plain[-1] == f"MA,{mark}"
    assert len(plain) == len(texts) + 2
    assert Counter(re.findall(r"[\^~][A-Z0-9]{2}", text)) == {
        "^XA": 1, "^CI": 1, "^PW": 1, "^LL": 1, "^FO": len(plain), "^A0": len(plain) - 1,
        "^FH": len(plain), "^FD": len(plain), "^FS": len(plain), "^BQ": 1, "^XZ": 1,
    }  # fmt: skip


def test_the_code_of_a_label_stands_clear_of_its_lines() -> None:
    for size in (LabelSize(40, 25), LabelSize(), LabelSize(300, 300), LabelSize(40, 300)):
        assert 0 < size.code <= min(size.width / 2, size.height)
    assert len(code_rows("A\nB")) >= 21


@pytest.mark.parametrize("size", ["100", "100x", "1000x60", "ax60", "nanxnan"])
def test_a_size_that_cannot_be_meant(size: str, tmp_path: Path) -> None:
    words = ("labels", str(SAMPLES / "tie.nc1"), "-o", str(tmp_path / "l.pdf"), "--size", size)
    assert call(*words).exit_code == 2


@pytest.mark.parametrize(("command", "name", "module"), [
    ("labels", "l.pdf", "reportlab.pdfgen.canvas"), ("list", "l.xlsx", "openpyxl"),
])  # fmt: skip
def test_a_library_that_is_not_there(
    command: str, name: str, module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, module, None)
    done = call(command, SAMPLES / "tie.nc1", "-o", tmp_path / name, status=1)
    assert "extra-missing" in done.stderr
    assert "pip install" in done.stderr
    assert not list(tmp_path.iterdir())


def test_post_makes_as_many_as_are_wanted_bar_by_bar(tmp_path: Path) -> None:
    """The parts recovered from all programs are those wanted, and no bar is too short."""
    inputs = [str(SAMPLES / name) for name in ("tie.nc1", "channel.nc1", "strut.nc1")]
    job = str(tmp_path / "job.gcode")
    done = call("post", *inputs, "--quantity", "7", "--bar", "6000", "-o", job, status=0)
    assert "plan-quantity" not in done.stderr
    made: Counter[tuple[str, int]] = Counter()
    for program in sorted(tmp_path.glob("job-*.gcode")):
        section, pieces = _recovered(program, tmp_path / "made")
        made.update((section, round(piece)) for piece in pieces)
    assert made == {("UPN200", 320): 7, ("UPN200", 3000): 7, ("IPE160", 1800): 7}
    call("post", inputs[0], "--quantity", "file", "-o", job, status=0)
    assert Path(job).exists()


def _recovered(program: Path, folder: Path) -> tuple[str, list[float]]:
    """The section that a program is right for, and the length of each piece that it makes."""
    for section in ("UPN200", "IPE160"):
        if call("recover", program, "--profile", section, "-o", f"{folder}/").exit_code == 0:
            found = []
            for path in folder.iterdir():
                (part,) = json.loads(call("inspect", path, "--json").stdout)["parts"]
                found += [part["length"]] * part["quantity"]
                path.unlink()
            return section, found
    raise AssertionError(f"{program} makes neither section")


def test_a_quantity_that_is_not_made_is_a_warning_with_the_option(tmp_path: Path) -> None:
    job = str(tmp_path / "job.gcode")
    done = call("post", SAMPLES / "tie.nc1", "-o", job)
    assert "warning plan-quantity: found a quantity of 2" in done.stderr
    assert "--quantity file" in done.stderr
    assert "plan-quantity" not in call("post", SAMPLES / "tie.nc1", "--quantity", "1", "-o",
                                      job).stderr  # fmt: skip
    text = (SAMPLES / "gusset.nc1").read_text(encoding="ascii").split("\n")
    text[7] = "  4"
    plate = str(tmp_path / "gusset.nc1")
    Path(plate).write_text("\n".join(text), encoding="ascii")
    said = call("post", plate, "-o", tmp_path / "p.ngc").stderr
    assert "warning plan-sheet-quantity: found a quantity of 4" in said
    once = call("post", plate, "--quantity", "file", "-o", tmp_path / "p.ngc")
    assert "plan-sheet-quantity" not in once.stderr


@pytest.mark.parametrize(
    ("asked", "made"), [((), 1), (("--quantity", "file"), 4), (("--quantity", "3"), 3)]
)
def test_a_batch_of_plates_makes_the_quantity_of_each(
    tmp_path: Path, asked: tuple[str, ...], made: int
) -> None:
    text = (SAMPLES / "gusset.nc1").read_text(encoding="ascii").split("\n")
    text[7] = "  4"
    (tmp_path / "gusset.nc1").write_text("\n".join(text), encoding="ascii")
    out = tmp_path / "out"
    done = call("batch", tmp_path / "gusset.nc1", *asked, "-o", out, "--json", status=0)
    assert ("plan-sheet-quantity" in done.stdout) == (not asked)
    (row,) = json.loads(done.stdout)["files"]
    assert sum(part["pieces"] for part in row["parts"]) == made
    program = (out / "gusset.ngc").read_text(encoding="ascii")
    assert program.count("\nM3 S1\n") == 5 * made  # four holes and the outline
    assert call("check", out).exit_code == 0


@pytest.mark.parametrize("sample", ["gusset.nc1", "tie.nc1"])
def test_a_program_of_a_quantity_is_verified_and_reported_with_it(
    tmp_path: Path, sample: str
) -> None:
    part, job = str(SAMPLES / sample), str(tmp_path / "job.prog")
    words = ("--quantity", "3")
    machine = "plate-linuxcnc" if sample == "gusset.nc1" else "beamline"
    call("post", part, *words, "-o", job, "--machine", machine, status=0)
    assert call("verify", job, "--against", part, *words, "--machine", machine).exit_code == 0
    assert call("verify", job, "--against", part, "--machine", machine).exit_code == 1
    page = str(tmp_path / "sheet.html")
    call("report", part, *words, "-o", page, "--machine", machine, status=0)
    program = Path(job).read_bytes()
    assert sha256(program).hexdigest() in Path(page).read_text(encoding="utf-8")


def test_more_bars_than_one_do_not_go_to_standard_output() -> None:
    done = call("post", SAMPLES / "channel.nc1", "--quantity", "3", "--bar", "6000", "-o", "-")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "write-more-bars" in done.stderr


def test_a_batch_makes_as_many_as_are_wanted_and_checks_them(tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = (str(SAMPLES / "tie.nc1"), str(SAMPLES / "channel.nc1"), "--quantity", "3")
    done = call(
        "batch", *words, "--bar", "6000", "--each", "-o", out, "--json", "--jobs", "1", status=0
    )
    assert sorted(p.name for p in out.glob("*.gcode")) == [
        "channel-1.gcode", "channel-2.gcode", "channel-3.gcode", "tie.gcode",
    ]  # fmt: skip
    rows = [part for row in json.loads(done.stdout)["files"] for part in row["parts"]]
    assert sum(part["pieces"] for part in rows if part["mark"] == "T1") == 3
    assert [part["pieces"] for part in rows if part["mark"] == "C1"] == [1, 1, 1]
    checked = call("check", out, status=0)
    assert "4 of 4 programs are the same" in checked.stdout


def test_numbers_of_a_list_of_manual_work_are_numbers() -> None:
    row = dict.fromkeys(HAND_HEAD, "") | {
        "x": -30.0, "angle": -12.5, "text": "-30", "path": "-30 20.5; 40 -20", "mark": "-1+1",
    }  # fmt: skip
    (cells,) = csv.DictReader(io.StringIO(hand_csv([row])))  # type: ignore[list-item]
    assert (cells["x"], cells["angle"], cells["text"]) == ("-30", "-12.5", "-30")
    assert (cells["path"], cells["mark"]) == ("-30 20.5; 40 -20", "'-1+1")


@given(st.text("0123456789.+-=@;, aE", max_size=12))
def test_a_cell_that_begins_a_formula_holds_numbers_alone(text: str) -> None:
    cell = harmless_cell(text)
    assert cell in (text, f"'{text}")
    if str(cell)[:1] in tuple("=+-@"):
        assert all(float(word) is not None for word in str(cell).replace(";", " ").split())
