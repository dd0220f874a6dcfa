"""Faults put into what counts and lays out: one line of a copy, and nothing wrong is posted.

Each edit is a mistake that a planner could make. The command has to end with exit 1 and to leave no
program; without the edit it posts.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.conftest import ROOT, SAMPLES, sampled

LAYOUT, REQUEST = "planning/contours/layout.py", "model/request.py"
STOCK = "planning/stock.py"
ROWS, HATCH = "planning/sheet_rows.py", "model/hatch.py"
ANGLE = """0
SECTION
2
ENTITIES
""" + "".join(
    f"0\nLINE\n8\n0\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n"
    for (a, b), (c, d) in zip(
        [(0, 0), (300, 0), (300, 80), (120, 80), (120, 200), (0, 200)],
        [(300, 0), (300, 80), (120, 80), (120, 200), (0, 200), (0, 0)],
        strict=True,
    )
) + "".join(f"0\nCIRCLE\n8\n0\n10\n{x}\n20\n{y}\n40\n{r}\n" for x, y, r in (
    (40, 40, 15), (60, 150, 20),
)) + "0\nENDSEC\n0\nEOF\n"  # fmt: skip

SHEET = ("angle.dxf", "--thickness", "3", "--machine", "plate-linuxcnc", "--map", "0=cut")
COPIES = (*SHEET, "--copies", "2x1", "--place", "corner", "--spacing", "20")
MIRROR_X = (*SHEET, "--mirror", "x", "--place", "corner")
TURNED = (*SHEET, "--rotate", "30", "--copies", "2x2", "--spacing", "20", "--place", "corner")
PLATES = (str(SAMPLES / "dstv/gusset.nc1"), "--quantity", "4", "--sheet", "1500x1000",
          "--machine", "plate-linuxcnc")  # fmt: skip
SHEETS = (*PLATES[:3], "--sheet", "640x260", *PLATES[5:])
BARS = (str(SAMPLES / "dstv/channel.nc1"), "--quantity", "3", "--bar", "12000")
MANY_BARS = (
    str(SAMPLES / "dstv/channel.nc1"),
    "--quantity",
    "5",
    "--bar",
    "12000",
    "--bar",
    "6000",
)
TWO_KINDS = (str(SAMPLES / "dstv/channel.nc1"), str(SAMPLES / "dstv/channel.nc1"), "--bar", "12000")
HATCHED = (
    "logo.dxf", "--thickness", "3", "--machine", "laser-grbl", "--config", "hatch.toml",
)  # fmt: skip
BEAM = (str(SAMPLES / "dstv/beam.nc1"),)


class Edit(NamedTuple):
    file: str
    old: str
    new: str
    words: tuple[str, ...]


EDITS = {
    "a copy lacks its last feature": Edit(
        LAYOUT, "for feature in turned.features\n", "for feature in turned.features[:-1]\n", COPIES
    ),
    "mirror is ignored": Edit(LAYOUT, 'torch.mirror == axis else', 'torch.mirror == "" else',
                              MIRROR_X),
    "mirror about the other axis": Edit(
        LAYOUT, 'for axis in ("x", "y"))', 'for axis in ("y", "x"))',
        (*MIRROR_X, "--copies", "2x1", "--spacing", "20"),
    ),
    "a plate less": Edit(REQUEST, "for _ in range(count))", "for _ in range(count - 1))", PLATES),
    "a piece of bar less": Edit(REQUEST, "for _ in range(count))", "for _ in range(count - 1))",
                                BARS),
    "a web that lies deeper": Edit("model/part.py", "return (self.width - web) / 2",
                                   "return (self.width - web) / 2 + 3", BEAM),
    "a piece more": Edit(REQUEST, "for _ in range(count))", "for _ in range(count + 1))", BARS),
    "the last bar is forgotten": Edit(STOCK, "for bar in nesting.bars\n",
                                      "for bar in nesting.bars[:-1]\n", MANY_BARS),
    "a bar twice": Edit(STOCK, "for bar in nesting.bars\n",
                        "for bar in (*nesting.bars, nesting.bars[0])\n", MANY_BARS),
    "a bar that is not in store": Edit(STOCK, "(bar.account.length,) if", "(14000.0,) if",
                                       BARS),
    "no quantity at all": Edit(
        REQUEST, "    return quantity if isinstance(quantity, int) else part.quantity",
        "    return 1", PLATES,
    ),
    "the second of two equal inputs is dropped": Edit(
        REQUEST, "return tuple(places)", "return tuple(places)[:1]", TWO_KINDS
    ),
    "a sheet lacks a piece": Edit(ROWS, "pieces[at : at + count]", "pieces[at : at + count - 1]",
                                  PLATES),
    "a sheet is skipped": Edit(ROWS, "        at += count", "        at += count + 1", SHEETS),
    "turned the other way": Edit(LAYOUT, "a, b, d, e = c * fx, -s * fy, s * fx, c * fy",
                                 "a, b, d, e = c * fx, s * fy, -s * fx, c * fy", TURNED),
    "a row less": Edit(LAYOUT, "for n in range(rows)", "for n in range(rows - 1)", TURNED),
    "copies too close": Edit(
        LAYOUT, "k * (x1 - x0 + torch.spacing)", "k * (x1 - x0 + 15.0)", TURNED
    ),
    "hatch too wide": Edit(
        HATCH, "distance = own.hatch or 0.0", "distance = 2 * (own.hatch or 0.0)", HATCHED
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("copy")
    # With the bytecode, which is that of the copies as well until they are edited.
    shutil.copytree(ROOT / "beamcam", folder / "beamcam")
    (folder / "angle.dxf").write_text(ANGLE)
    (folder / "logo.dxf").write_text(ANGLE.replace("\n8\n0\n", "\n8\nLOGO\n"))
    (folder / "hatch.toml").write_text('[map]\nLOGO = { process = "engrave", hatch = 2.0 }\n')
    return folder


def posted(copy: Path, words: tuple[str, ...], out: Path) -> subprocess.CompletedProcess[str]:
    out.mkdir()
    program = "job.nc" if "laser-grbl" in words else "job.ngc" if "plate-linuxcnc" in words else "j"
    return subprocess.run(
        [sys.executable, "-m", "beamcam", "post", *words, "-o", str(out / program)],
        cwd=copy, env={**os.environ, "PYTHONPATH": str(copy)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip


@pytest.mark.parametrize(
    "words", sampled([(words,) for words in sorted({e.words for e in EDITS.values()})], 12)
)
def test_without_an_edit_it_is_posted(copy: Path, words: tuple[str, ...], tmp_path: Path) -> None:
    done = posted(copy, words, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert [*(tmp_path / "out").iterdir()]


@pytest.mark.parametrize("name", sampled(EDITS, 3))
def test_no_edit_is_posted(copy: Path, name: str, tmp_path: Path) -> None:
    edit = EDITS[name]
    file = copy / "beamcam" / edit.file
    text = file.read_text(encoding="utf-8")
    assert text.count(edit.old) == 1, "the edit does not fit the code any more"
    try:
        file.write_text(text.replace(edit.old, edit.new), encoding="utf-8")
        done = posted(copy, edit.words, tmp_path / "out")
    finally:
        file.write_text(text, encoding="utf-8")
    assert done.returncode == 1, f"posted: {done.stdout} {done.stderr}"
    assert "error verify-" in done.stderr, done.stderr
    left = [path for path in (tmp_path / "out").iterdir() if not path.name.endswith(".refused")]
    assert left == []
