"""T sections whose header has the stem where the width of the flange is expected."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from beamcam.readers.dstv import read
from tests.conftest import SAMPLES

OUTLINE = (SAMPLES / "bad" / "dstv" / "dstv-tee-outline.nc1").read_text()
NAME = (SAMPLES / "bad" / "dstv" / "dstv-tee-name.nc1").read_text()


def sized(text: str, high: float, wide: float, drawn: float = 180.0) -> bytes:
    text = text.replace("       200.00\n       180.00\n", f"{high:13.2f}\n{wide:13.2f}\n")
    return text.replace("     180.00      0.00", f"{drawn:11.2f}      0.00").encode()


def test_outlines_say_which_is_which() -> None:
    reading = read(OUTLINE.encode(), "p.nc1")
    (part,) = reading.parts
    p = part.profile
    assert (p.height, p.width, p.flange_thickness, p.web_thickness) == (180, 200, 8.6, 13.5)
    assert [d.code for d in reading.diagnostics] == ["dstv-tee-outline"]


@given(st.integers(60, 400), st.integers(60, 400))
def test_a_t_is_read_as_it_is_drawn_whichever_way_its_header_stands(high: int, wide: int) -> None:
    """Read once, the other header gives the same part, told where it was turned."""
    assume(abs(high - wide) > 1)
    readings = [read(sized(OUTLINE, *pair, wide), "p.nc1") for pair in ((high, wide), (wide, high))]
    sizes = [(r.parts[0].profile.height, r.parts[0].profile.width) for r in readings]
    assert sizes == [(wide, high)] * 2
    told = ["dstv-tee-outline" in {d.code for d in r.diagnostics} for r in readings]
    assert told == [True, False]


@pytest.mark.parametrize(
    ("name", "high", "wide", "told"),
    [
        ("1/2 IPE400", 200, 180, True), ("1/2 IPE400", 180, 200, False),
        ("HEA240/2", 115, 240, True), ("HEA240/2", 240, 115, False),
        ("WT155X26", 159, 205, True), ("WT155X26", 205, 159, False),
        ("WT6X20", 151.6, 203.5, True), ("WT6X20", 203.5, 151.6, False),
        ("T100", 100, 100, False), ("T200", 200, 100, False), ("1/2 HEA100", 48, 100, True),
    ],
)  # fmt: skip
def test_a_name_that_contradicts_the_header_is_told(
    name: str, high: float, wide: float, told: bool
) -> None:
    reading = read(sized(NAME.replace("1/2 IPE400", name), high, wide), "p.nc1")
    assert reading.parts[0].profile.height == high
    assert ("dstv-tee-name" in {d.code for d in reading.diagnostics}) is told
