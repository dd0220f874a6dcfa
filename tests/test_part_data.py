"""What the head of a program says of its parts, and what it cannot say."""

from pathlib import Path

import pytest

from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.model.description import PART_DATA, part_data
from beamcam.pipeline import post
from beamcam.readers import read
from tests.conftest import SAMPLES
from tests.runs import call, part

HEADER = " ".join(f"{name}={{{name}}}" for name in PART_DATA)


def machine(folder: Path, base: str, header: str) -> str:
    path = folder / "mine.toml"
    own = load(base).words.header
    lines = ", ".join(repr(line) for line in (own[0], f"({header})", *own[1:]))
    path.write_text(f'base = "{base}"\n[words]\nheader = [{lines}]\n')
    return str(path)


def test_a_bar_says_the_data_of_its_parts_once(tmp_path: Path) -> None:
    on = load(machine(tmp_path, "beamline", HEADER))
    parts = [read(part(mark, quantity=q).encode(), "a.nc1").parts[0] for mark, q in
             (("A", 2), ("B", 2), ("A", 2))]  # fmt: skip
    text = post(parts, on).text
    assert (
        "(mark=A+B name=a profile=UPN200 grade=S235JR length=2000 quantity=2 order=TEST "
        "drawing=1 phase=1 date=)" in text
    )
    assert part_data(parts)["mark"] == "A+B"


def test_a_sheet_says_them_too(tmp_path: Path) -> None:
    place = machine(tmp_path, "plate-linuxcnc", HEADER)
    out = tmp_path / "a.ngc"
    words = ["post", str(SAMPLES / "dstv" / "gusset.nc1"), "-o", str(out), "--machine", place]
    assert call(*words).exit_code == 0
    (line,) = (line for line in out.read_text().splitlines() if "mark=" in line)
    assert set(PART_DATA) == {
        word.partition("=")[0] for word in line.strip("()").split() if "=" in word
    }


@pytest.mark.parametrize("name", ["width", "height", "section", "marc"])
def test_what_a_sheet_cannot_say_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(MachineError, match="machine-value"):
        load(machine(tmp_path, "plate-linuxcnc", f"{{{name}}}"))
