"""Contours that cross one another, and those that double back, followed without a kerf."""

import re

import pytest

from beamcam.geometry.curves import Bezier, Line
from beamcam.pipeline import post
from beamcam.verify.sheets import verify_sheet

from .parts import box, circle, contour, drawing, lines, table

MACHINE = table("laser-grbl", material="wood", kerf_by="none", lead="none")

TONGUE = drawing(contour(lines((0, 0), (60, 0), (60, 30), (-30, 30), (0, 30))), thickness=3.0)
SPIKE = drawing(
    contour(
        (*lines((0, 0), (60, 0), (60, 30), closed=False), Bezier(((60, 30), (90, 40), (60, 30))),
         Line((60, 30), (0, 0)))
    ),
    thickness=3.0,
)  # fmt: skip
CROSSED = drawing(
    contour(box(0, 0, 100, 40), line=1),
    contour(box(20, 20, 10, 60), line=2),
    contour(circle(25, 30, 6), line=3),
    thickness=3.0,
)


def strokes(text: str) -> list[str]:
    return re.findall(r"^G0 X\S+ Y\S+\nM[34](?:.|\n)*?M5\n", text, re.M)


@pytest.mark.parametrize("part", [TONGUE, SPIKE])
def test_a_contour_that_doubles_back_is_posted_and_not_followed_again(part: object) -> None:
    text = post((part,), MACHINE).text  # type: ignore[arg-type]
    assert not verify_sheet(text, (part,), MACHINE)  # type: ignore[arg-type]
    (first, *_) = strokes(text)
    again = verify_sheet(text.replace(first, first * 2), (part,), MACHINE)  # type: ignore[arg-type]
    assert "verify-sheet-twice" in {said.code for said in again}


def test_a_tongue_that_is_cut_short_is_told() -> None:
    """Half of the line that the contour has twice, and that is followed once."""
    text = post((TONGUE,), MACHINE).text
    short = text.replace("G0 X2 Y32", "G0 X17 Y32")
    assert short != text
    codes = {said.code for said in verify_sheet(short, (TONGUE,), MACHINE)}
    assert "verify-sheet-missing" in codes


def test_what_lies_in_two_contours_that_cross_is_cut_before_both() -> None:
    text = post((CROSSED,), MACHINE).text
    assert not verify_sheet(text, (CROSSED,), MACHINE)
    cuts = strokes(text)
    assert len(cuts) == 3
    (round_cut,) = [cut for cut in cuts if re.search(r"^G[23] ", cut, re.M)]
    assert cuts[0] == round_cut
    late = text.replace(round_cut, "").replace(cuts[2], cuts[2] + round_cut)
    assert "verify-sheet-order" in {said.code for said in verify_sheet(late, (CROSSED,), MACHINE)}
