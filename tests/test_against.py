"""`simulate` and `report`: parts posted in memory, and programs held against their parts."""

from pathlib import Path

import pytest

from tests.conftest import SAMPLES
from tests.runs import BAD, call, part

TIE, CHANNEL = str(SAMPLES / "dstv" / "tie.nc1"), str(SAMPLES / "dstv" / "channel.nc1")
GUSSET = str(SAMPLES / "dstv" / "gusset.nc1")


@pytest.mark.parametrize(("source", "program"), [(TIE, "tie.gcode"), (GUSSET, "gusset.ngc")])
def test_a_part_is_simulated_as_its_program_is(source: str, program: str, tmp_path: Path) -> None:
    job = str(tmp_path / program)
    assert call("post", source, "-o", job, "--job", Path(program).stem).exit_code == 0
    traces = []
    for words in ((source,), (job,), (job, "--against", source), (job, source)):
        call("simulate", *words, "-o", tmp_path / "trace.csv", status=0)
        traces.append((tmp_path / "trace.csv").read_text(encoding="utf-8"))
    steps = [[line.rsplit(",", 1)[0] for line in trace.splitlines()] for trace in traces]
    assert len(steps[0]) > 20
    assert all(one == steps[0] for one in steps)


@pytest.mark.parametrize("command", ["simulate", "report"])
def test_a_program_that_is_not_of_its_part_is_refused(command: str, tmp_path: Path) -> None:
    job, out = str(tmp_path / "tie.gcode"), str(tmp_path / "out")
    assert call("post", TIE, "-o", job).exit_code == 0
    out += ".csv" if command == "simulate" else ".html"
    assert call(command, job, "--against", TIE, "-o", out).exit_code == 0
    done = call(command, job, "--against", CHANNEL, "-o", out)
    assert (done.exit_code, "verify-hole-missing" in done.stderr) == (1, True)
    alone = call(command, job, "--against", "-o", out)
    assert (alone.exit_code, "--against needs at least one PART" in alone.stderr) == (2, True)


@pytest.mark.parametrize("command", ["simulate", "report", "plot"])
def test_what_the_reader_said_is_passed_on(command: str, tmp_path: Path) -> None:
    """Also where the part is refused afterwards: its file may be the reason."""
    twice = "  v  100.00u   60.00    18.00\n"
    good = part("A").replace(twice, twice * 2)
    (tmp_path / "good.nc1").write_text(good, encoding="ascii")
    bad = BAD.replace("EN\n", twice * 2 + "EN\n")
    (tmp_path / "bad.nc1").write_text(bad, encoding="ascii")
    out = {"simulate": "t.csv", "report": "r.html", "plot": "p.svg"}[command]
    words = ("-o", str(tmp_path / out), *(("--show", "program") if command == "plot" else ()))
    for name, status in (("good", 0), ("bad", 1)):
        done = call(command, tmp_path / f"{name}.nc1", *words)
        assert done.exit_code == status, done.stderr
        assert "warning dstv-hole-duplicate" in done.stderr
