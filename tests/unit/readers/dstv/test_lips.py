"""How long the lips of a C are, by the name of its section."""

import pytest

from beamcam.readers.dstv import read
from tests.conftest import SAMPLES

LIPPED = (SAMPLES / "dstv" / "lipped.nc1").read_text()  # 200 x 70, 2 mm thick
NAME = "C200*70*20*2"


@pytest.mark.parametrize(
    ("name", "lip"),
    [
        (NAME, 20.0), ("C200x70x20x2.0", 20.0), ("C 200 X 70 X 20 X 2,0", 20.0),
        ("LIP C 200 x 70 x 20 x 2", 20.0), ("CC200-2-20-70", 20.0), ("C200×70×2×18.5", 18.5),
        ("C200", None), ("C20020", None), ("C200*70*2", None), ("C200*70*20*2*4", None),
        ("Z200*70*20*2", 20.0),  # whose code C says what it is
    ],
)  # fmt: skip
def test_a_name_says_it(name: str, lip: float | None) -> None:
    reading = read(LIPPED.replace(NAME, name).encode("latin-1"), "p.nc1")
    assert [part.profile.lip for part in reading.parts] == [lip]
    assert {d.code for d in reading.diagnostics} <= {"dstv-encoding"}


@pytest.mark.parametrize(
    "name", ["C200*75*20*2", "C150*70*20*2", "C200*70*20*3", "C200*70*120*2", "C200*70*3*2"]
)
def test_a_name_that_is_not_that_of_the_header_says_nothing(name: str) -> None:
    reading = read(LIPPED.replace(NAME, name).encode(), "p.nc1")
    assert [part.profile.lip for part in reading.parts] == [None]
    assert [d.code for d in reading.diagnostics] == ["dstv-lip-name"]


def test_a_rolled_channel_of_four_figures_has_no_lips() -> None:
    text = LIPPED.replace(NAME, "U200*70*11.5*8.5").replace("\n  C\n", "\n  U\n", 1)
    text = text.replace("         2.00\n         2.00\n", "        11.50\n         8.50\n", 1)
    reading = read(text.encode(), "p.nc1")
    assert [part.profile.lip for part in reading.parts] == [None]
    assert not [d for d in reading.diagnostics if d.code.startswith("dstv-lip")]
