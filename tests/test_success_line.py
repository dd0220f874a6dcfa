"""The one line that `post` says of what it wrote."""

from pathlib import Path

import pytest
from click.testing import Result

from tests.conftest import SAMPLES
from tests.runs import call

DSTV = SAMPLES / "dstv"


def post(*words: object) -> Result:
    done = call("post", *words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


@pytest.mark.parametrize(
    ("words", "output", "line"),
    [
        ((DSTV / "channel.nc1", "--bar", 12000), "channel.gcode",
         "14 holes, 2 cuts, 1 bar of 12000, 3:14 min; read back: the part, exactly"),
        ((DSTV / "tie.nc1", DSTV / "tie.nc1"), "ties.gcode",
         "8 holes, 3 cuts, 1 bar of 12000, 2:20 min; read back: the 2 parts, exactly"),
        ((DSTV / "gusset.nc1",), "g.ngc",
         "5 contours, 1 marked line, 1 sheet of 6 mm, 0:40 min; read back: the part, exactly"),
        ((SAMPLES / "json" / "shield-small.json",), "s.st",
         "1 contour, 1 sheet of 8 mm, 0:12 min; read back: the part, exactly"),
        ((SAMPLES / "json" / "shield-small.json", "--no-verify"), "s.steps",
         "1 contour, 1 sheet of 8 mm, 0:05 min; NOT read back"),
        ((SAMPLES / "bad" / "slot.nc1", "--machine", "beamline", "--allow-skips", "slot"),
         "s.gcode",
         "2 cuts, 1 bar of 4024.04, 0:42 min; read back: the part but for 1 feature left out"),
        ((DSTV / "marked.nc1", "--machine", "beamline"), "m.gcode",
         "3 holes, 2 cuts, 1 bar of 2424.04, 1:43 min; "
         "read back: the part but for 3 features left for manual work"),
        ((DSTV / "channel.nc1", "--from-operation", 4), "rest.gcode",
         "operations 4 to 12 of 12; read back: the rest of the whole program, exactly"),
        ((SAMPLES / "dxf" / "plate.dxf", "--thickness", 3, "--from-contour", 2), "rest.ngc",
         "contours 2 to 7 of 7; read back: the rest of the whole program, exactly"),
        ((SAMPLES / "coping" / "coped.nc1", "--machine", "coper-linuxcnc"), "coped.ngc",
         "14 cuts, 1260 mm of bar, 1:47 min; read back: the part but for 4 corners rounded"),
    ],
)  # fmt: skip
def test_a_line_says_what_was_written(
    tmp_path: Path, words: tuple[object, ...], output: str, line: str
) -> None:
    done = post(*words, "-o", tmp_path / output)
    assert done.exit_code == 0, done.stderr
    assert done.stderr.splitlines()[-1] == f"{output}: {line}"
    assert done.stdout == ""


def test_a_line_for_each_program(tmp_path: Path) -> None:
    done = post(DSTV / "channel.nc1", "--quantity", 2, "--bar", 6000, "-o", tmp_path / "c.gcode")
    assert [line.partition(":")[0] for line in done.stderr.splitlines()[-2:]] == [
        "c-1.gcode", "c-2.gcode",
    ]  # fmt: skip
    done = post(DSTV / "channel.nc1", "-o", "-")
    assert done.stderr.startswith("the program: 14 holes, ")


def test_no_line_where_nothing_is_wanted_or_nothing_was_written(tmp_path: Path) -> None:
    out = tmp_path / "c.gcode"
    assert post(DSTV / "channel.nc1", "-o", out, "--quiet").stderr == ""
    assert "read back" not in post(DSTV / "channel.nc1", "-o", out, "--json").stderr
    refused = post(SAMPLES / "bad" / "slot.nc1", "--machine", "beamline", "-o", out)
    assert refused.exit_code == 1
    assert "read back" not in refused.stderr
