"""What people type wrong at first, each with the line that helps them on."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from beamcam.cli import main
from tests.conftest import SAMPLES
from tests.runs import part

STEP = (
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('a.stp','','','','','','');\n"
    "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
    "#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n"
)
FILES = {
    "A.nc1": part("A").encode(), "B.nc1": part("B").replace("UPN200", "UPN180").encode(),
    "model.step": STEP.encode(), "drawing.pdf": b"%PDF-1.4\n", "parts.zip": b"PK\3\4\0\0",
    "list.xls": b"\xd0\xcf\x11\xe0\xa1\xb1", "mesh.stl": b"solid a\nendsolid a\n",
    "drawing.dwg": b"AC1032\0\0\0\0", "photo.png": b"\x89PNG\r\n\x1a\n", "empty.nc1": b"",
    "plate.dxf": (SAMPLES / "dxf" / "plate.dxf").read_bytes(),
    "jobs/A.nc1": part("A").encode(),
}  # fmt: skip
#: What was typed, and what the answer says; of a mistake each.
MISTAKES = (
    ("post A.nc1 -o a.gcode --bar 6m",
     "found '6m'; expected a number above 0, without a unit: 6000"),
    ("post A.nc1 -o a.gcode --bar 6000mm", "without a unit: 6000 (mm)"),
    ("post A.nc1 -o a.gcode --bar 6,000",
     "found '6,000'; expected a number above 0, without commas: 6000"),
    ("post A.nc1 -o a.gcode --bar 6.000", "with --bar 6000 it can be made"),
    ("post A.nc1 -o a.gcode --bar 20ft", "without a unit: 6096 (mm)"),
    ("list A.nc1 --bar 12m", "without a unit: 12000 (mm)"),
    ("post plate.dxf -o a.ngc --thickness 1,5", "with a point: 1.5"),
    ("post plate.dxf -o a.ngc --thickness 3mm", "without a unit: 3 (mm)"),
    ("post A.nc1 -o a.gcode --bar -6000", "found '-6000'; expected a number above 0"),
    ("post A.nc1 -o a.gcode --quantity 2x", "found '2x'; expected file, or 1 to 100000"),
    ("post A.nc1 -o a.gcode --quantity 0", "expected file, or 1 to 100000"),
    ("post model.step -o a.gcode",
     "found a STEP model (AUTOMOTIVE_DESIGN); expected the model exported as IFC"),
    ("post drawing.pdf -o a.gcode", "found a PDF; expected the drawing as DXF or SVG"),
    ("post drawing.dwg -o a.gcode",
     "found a DWG file (AC1032), expected DXF: save the drawing as DXF"),
    ("post parts.zip -o a.gcode", "found a zip archive; expected its files, unpacked"),
    ("list list.xls", "found a document of Office; expected a part as DSTV or IFC"),
    ("post mesh.stl -o a.gcode", "found a mesh (STL); expected a part as DSTV or IFC"),
    ("inspect photo.png", "found a picture; expected the drawing as DXF or SVG"),
    *((f"{words} drawing.pdf{out}", "found a PDF; expected the drawing as DXF or SVG")
      for words, out in (("plot", " -o p.svg"), ("report", " -o r.html"), ("verify", ""),
                         ("simulate", " -o s.csv"), ("recover", " -o r.nc1"),
                         ("diff A.nc1", ""))),
    ("post empty.nc1 -o a.gcode", "found an empty file; expected a part or a drawing"),
    ("post jobs -o a.gcode", "`beamcam batch jobs -o OUT` posts the files of a folder"),
    ("post nothing.nc1 -o a.gcode", "nothing.nc1: error read-file: found no file that can be read"),
    ("post a.gcode -o b.gcode", "found a program; expected parts (`beamcam verify`, `plot`"),
    ("inspect a.gcode", "found a program; expected parts"),
    ("post A.nc1 -o jobs", "a folder: name a file in it, `beamcam batch` writes to folders"),
    ("post A.nc1 -o new/", "a folder: name a file in it, `beamcam batch` writes to folders"),
    ("post A.nc1", "Missing option '-o'"),
    ("post A.nc1 -o A.nc1", "expected the name of a program (`beamcam convert` writes such)"),
    ("post A.nc1 -o a.pdf", "expected the name of a program (`beamcam plot` writes such)"),
    ("post A.nc1 -o a.gcode --machine beamlin", "found no machine 'beamlin'; expected 'beamline'"),
    ("post A.nc1 -o a.gcode --machine plate-gcode",
     "found no machine 'plate-gcode'; expected 'plate-codesys'"),
    ("post A.nc1 -o a.gcode --machine mine.toml",
     "found no machine 'mine.toml'; expected one of beamline"),
    ("post A.nc1 -o a.gcode --machine plate-linuxcnc", "with --machine beamline"),
    ("post A.nc1 B.nc1 -o a.gcode",
     "with `beamcam batch` (a program for each part) it can be made"),
    ("post A.nc1 -o a.gcode --order bset", "'bset' is not one of 'given', 'best'"),
    ("post A.nc1 -o a.gcode --allow-skips lettering", "'lettering' is not one of 'tool'"),
    ("post A.nc1 -o a.gcode --date 29.02.2024", "expected today or a day as 2024-02-29"),
    ("post A.nc1 -o a.gcode --allowskips text", "Did you mean"),
    ("pots A.nc1 -o a.gcode", "No such command 'pots'. Did you mean 'post'?"),
    ("verify a.gcode A.nc1", "PARTs come after --against."),
    ("verify A.nc1", "found the part 'A.nc1'; expected a program (`beamcam post` makes one of it)"),
    ("verify A.nc1 --against a.gcode", "found a program; expected parts"),
    ("recover A.nc1 -o b.nc1", "found the part 'A.nc1'; expected a program"),
    ("report A.nc1 --against A.nc1 -o r.html", "Without --against parts are posted."),
    ("diff A.nc1 a.gcode", "found the part 'A.nc1' and the program 'a.gcode'"),
    ("batch A.nc1", "Missing option '-o'"),
    ("batch none/*.nc1 -o out", "found no input for 'none/*.nc1'; expected a file, a folder"),
    ("labels A.nc1", "Say where the labels go: -o labels.pdf"),
    ("labels A.nc1 -o l.doc",
     "found '.doc' for the output's format; expected one of .pdf, .zpl, .json"),
    ("labels A.nc1 -o l.pdf --size 100", "expected WIDTHxHEIGHT in mm"),
    ("list A.nc1 -o l.xls", "expected one of .txt, .csv, .xlsx, .json"),
    ("simulate a.gcode", "Say where the trace goes: -o FILE"),
    ("simulate a.gcode -o t.csv --every 10", "expected a time above 0 such as 10ms or 0.5s"),
    ("convert A.nc1 -o a.step", "found '.step' for the output's format; expected one of"),
    ("post A.nc1 -o a.gcode --config none.toml", "found no configuration that can be read"),
)  # fmt: skip


@pytest.mark.parametrize(("typed", "answer"), MISTAKES, ids=[typed for typed, _ in MISTAKES])
def test_a_mistake_is_answered_with_a_line_that_helps(
    typed: str, answer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("jobs").mkdir()
    for name, data in FILES.items():
        Path(name).write_bytes(data)
    run = CliRunner().invoke
    assert run(main, ["post", "A.nc1", "-o", "a.gcode"]).exit_code == 0
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    done = run(main, typed.split())
    assert isinstance(done.exception, SystemExit), done.exception
    assert done.exit_code in (1, 2)
    lines = [" ".join(line.split()) for line in done.stderr.splitlines()]
    assert any(answer in line for line in lines), done.stderr
    said = [line for line in lines if line and not line.startswith(("Usage:", "Try "))]
    assert len(said) <= 4, done.stderr
    assert before == {path: path.read_bytes() for path in before}
