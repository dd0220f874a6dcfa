"""Programs and messages, byte for byte.

A folder of tests/golden is a machine, a file's stem names its samples (`a+b` lays two on one bar).
A new case is one command: `beamcam post samples/dstv/a.nc1 --machine m -o tests/golden/m/a.gcode`.
"""

from pathlib import Path

import pytest

from tests.conftest import GOLDEN, ROOT, SAMPLES, Golden
from tests.runs import call

PROGRAMS = sorted(p for p in GOLDEN.glob("*/*") if p.parent.name != "messages")
BAD = sorted((SAMPLES / "bad").glob("*.*"))


def sample(stem: str) -> str:
    """The path of the sample of that name, whatever its format."""
    found = (p for p in SAMPLES.glob(f"*/{stem}.*") if p.parent.name != "bad")
    (path,) = (p for p in found if p.suffix != ".toml")
    return str(path.relative_to(ROOT))


def machine_of(folder: str) -> str:
    """A shipped machine, or the file of one among the samples."""
    own = SAMPLES / "machines" / f"{folder}.toml"
    return str(own.relative_to(ROOT)) if own.is_file() else folder


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_program(
    path: Path, golden: Golden, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(ROOT)
    inputs = [sample(stem) for stem in path.stem.split("+")]
    made = tmp_path / path.name  # the suffix may say in which form a table is written
    # A sample may have a configuration of its name.
    own = [p for p in (Path(name).with_suffix(".toml") for name in inputs) if p.is_file()]
    config = [word for p in own for word in ("--config", str(p))]
    machine = machine_of(path.parent.name)
    call("post", *inputs, *config, "--machine", machine, "-o", made, status=0)
    golden.check(path, made.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", BAD, ids=lambda p: p.name)
def test_message(path: Path, golden: Golden, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is said about a bad input, on the machine that is the first choice."""
    monkeypatch.chdir(ROOT)
    machine = "plate-linuxcnc" if path.stem.startswith("plate") else "beamline"
    words = ["post", str(path.relative_to(ROOT)), "--machine", machine, "-o", "-"]
    run = call(*words, status=1)
    assert run.stdout == ""
    golden.check(GOLDEN / "messages" / f"{path.stem}.txt", run.stderr)


def test_every_machine_has_a_golden_program() -> None:
    from beamcam.machine import shipped

    assert set(shipped()) <= {p.parent.name for p in PROGRAMS}


def test_the_comparison_can_fail(tmp_path: Path) -> None:
    path = tmp_path / "a.gcode"
    path.write_text("G01 X1\n")
    Golden(update=False).check(path, "G01 X1\n")
    with pytest.raises(pytest.fail.Exception, match=r"-G01 X1\n\+G01 X2"):
        Golden(update=False).check(path, "G01 X2\n")
