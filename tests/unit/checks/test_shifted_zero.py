"""Programs of CODESYS whose zero is moved, or whose corners are cut: read, run and verified."""

import re
from pathlib import Path

import numpy as np
import pytest

from beamcam.machine import load
from beamcam.simulation.program import simulate_program
from tests.conftest import SAMPLES
from tests.runs import call

JOBS = (("beamline", "channel"), ("beamline-annex", "channel"), ("plate-codesys", "gusset"))
SHIFT = {"X": 37.0, "Y": -12.0, "Z": 5.0}


def program(machine: str, part: str, folder: Path) -> tuple[str, str]:
    """A program of the machine for a sample, and the sample."""
    sample, path = str(SAMPLES / "dstv" / f"{part}.nc1"), folder / "job.gcode"
    call("post", sample, "--machine", machine, "-o", path, status=0)
    return path.read_text(), sample


def codes(text: str, machine: str, sample: str, folder: Path) -> set[str]:
    """Codes of the errors of a program."""
    path = folder / "other.gcode"
    path.write_text(text)
    words = ["verify", str(path), "--machine", machine, "--against", sample]
    done = call(*words)
    found = set(re.findall(r"error ([a-z-]+):", done.output))
    assert (done.exit_code == 0) == (not found)
    return found


def shifted(text: str, axes: str) -> str:
    """A program whose places count from elsewhere, as they are said there; zero is put back."""

    def moved(match: re.Match[str]) -> str:
        return f"{match[1]}{float(match[2]) - SHIFT[match[1]]:g}"

    own = re.sub(rf"\b([{axes}])(-?[\d.]+)", moved, text)
    zero = " ".join(f"{axis}{SHIFT[axis] / 2:g}" for axis in axes)
    head, line, rest = own.partition("G90\n")
    return f"{head}{line}G54 {zero}\nG55 {zero}\n{rest}".replace("M30\n", "G53\nM30\n")


@pytest.mark.parametrize(("name", "part"), JOBS)
def test_a_program_from_another_zero_is_the_same_work(name: str, part: str, tmp_path: Path) -> None:
    text, sample = program(name, part, tmp_path)
    machine = load(name)
    axes = "XYZ" if machine.stock == "beam" else "XY"
    other = shifted(text, axes)
    assert codes(other, name, sample, tmp_path) == set()
    one, two = (simulate_program(t, machine).trace for t in (text, other))
    assert np.allclose(one.positions, two.positions, atol=1e-6)
    assert one.duration_s == pytest.approx(two.duration_s)
    unmoved = other.replace("G55", "G54")
    assert codes(unmoved, name, sample, tmp_path)


@pytest.mark.parametrize(
    ("name", "part", "word", "refused"),
    [
        ("plate-codesys", "gusset", "G52 D0", set()),
        ("plate-codesys", "gusset", "G52 D0.5", {"verify-sheet-corner"}),
        ("plate-codesys", "gusset", "G51 D0.5", {"verify-sheet-corner"}),
        ("beamline", "channel", "G51 D0.01", set()),
        ("beamline", "channel", "G51 D5", {"verify-word"}),
        ("beamline", "channel", "G50", set()),
        ("plate-codesys", "gusset", "M98", {"verify-sheet-word"}),
        ("beamline", "channel", "G56", {"verify-word"}),
    ],
)
def test_corners_that_are_cut_off_are_refused_beyond_the_tolerance(
    name: str, part: str, word: str, refused: set[str], tmp_path: Path
) -> None:
    text, sample = program(name, part, tmp_path)
    assert codes(text.replace("G90\n", f"G90\n{word}\n"), name, sample, tmp_path) == refused
