"""Messages about the angles of a part's ends name the line of the file where each one stands."""

import pytest

from beamcam.errors import Diagnostic, PlanError
from beamcam.machine import load
from beamcam.planning.beam import plan_bar
from beamcam.planning.turning import TURNS, turned
from beamcam.readers import read
from tests.runs import part as dstv

PLACES = ("web start", "web end", "flange start", "flange end")
FIRST = 19  #: line of the file that `runs.part` writes the first angle in, a comment above it


def file_with(length: float = 2000.0, **angles: float) -> tuple[str, dict[str, int]]:
    """A DSTV file with angles in its header, by their places; and the line of each."""
    rows = dstv("A", length).splitlines()
    lines = {place: FIRST + k for k, place in enumerate(PLACES)}
    for name, angle in angles.items():
        rows[lines[name.replace("_", " ")] - 1] = f"  {angle:g}"
    return "\n".join(rows) + "\n", lines


def said_of(text: str) -> tuple[Diagnostic, ...]:
    (one,) = read(text.encode(), "a.nc1").parts
    try:
        return plan_bar([one], load("beamline")).remarks
    except PlanError as error:
        return tuple(error.diagnostics)


@pytest.mark.parametrize(
    ("place", "angle", "code"),
    [
        ("web_start", 65.0, "plan-saw-angle"),
        ("web_end", -50.0, "plan-saw-angle"),
        ("flange_start", 20.0, "plan-flange-cut"),
        ("flange_end", -20.0, "plan-flange-cut"),
        ("web_end", 0.05, "plan-cut-noise"),
        ("flange_end", 0.05, "plan-cut-noise"),
    ],
)
def test_an_angle_is_named_as_in_the_file_with_its_own_line(
    place: str, angle: float, code: str
) -> None:
    text, lines = file_with(**{place: angle})
    (said,) = (one for one in said_of(text) if one.code == code)
    assert said.source.line == lines[place.replace("_", " ")]
    assert f"found a cut of {angle:g}" in said.message or f" cut of {angle:g} " in said.message


def test_ends_that_cross_are_told_at_the_angle_of_the_end() -> None:
    text, lines = file_with(100.0, web_start=-45.0, web_end=45.0)
    crossing = [one for one in said_of(text) if one.code == "plan-cuts-cross"]
    assert [one.source.line for one in crossing] == [lines["web end"]]


def test_the_lines_go_with_the_angles_when_the_part_is_turned() -> None:
    text, lines = file_with(web_start=10.0, web_end=20.0, flange_start=3.0, flange_end=4.0)
    (one,) = read(text.encode(), "a.nc1").parts
    of_angle = dict(zip((10.0, 20.0, 3.0, 4.0), lines.values(), strict=True))
    for turn in TURNS:
        after = turned(one, turn)
        cuts = after.cuts
        angles = (cuts.web_start, cuts.web_end, cuts.flange_start, cuts.flange_end)
        assert after.cut_lines == tuple(of_angle[abs(angle)] for angle in angles)
