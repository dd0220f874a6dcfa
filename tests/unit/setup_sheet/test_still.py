"""The solid on paper: seen from the front, above and right, with each hole where it is."""

import io
from typing import Any

import numpy as np
import pypdfium2
import pytest

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.model.part import Hole, Part, Profile
from beamcam.pictures import ReadProgram
from beamcam.pictures.program import bar_made
from beamcam.pipeline import post
from beamcam.setup_sheet.content import SheetSources, content_of
from beamcam.setup_sheet.paper import setup_pdf
from beamcam.setup_sheet.solid_data import solids_of
from beamcam.setup_sheet.still import Still, still_of
from tests.conftest import sampled

HERE = Source("chiral.nc1", 1)
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
#: Diameter: x, y on the web; no two the mirror image of each other.
HOLES = {26.0: (70.0, 60.0), 18.0: (300.0, 70.0), 22.0: (120.0, 140.0)}


def program(flip: bool = False) -> ReadProgram:
    holes = tuple(Hole("v", x, 200.0 - y if flip else y, d, HERE) for d, (x, y) in HOLES.items())
    part, line = Part("CH1", CHANNEL, 400.0, HERE, features=holes), load("beamline-annex")
    return ReadProgram(post([part], line).text.encode(), line, "job.gcode", "", (part,))


def picture(flip: bool = False) -> Still:
    job = program(flip)
    pieces = [p for p in solids_of(job, bar_made(job)).pieces if p["kind"] == "part"]
    return still_of(pieces, "vouh", 1600, 500)


def islands(pixels: Any) -> list[tuple[int, float, float]]:
    """Pixels, column and row of each spot of paper that steel lies all round, the largest first.

    Runs of paper in a row are one spot with those of the row before that they touch.
    """
    paper = np.pad((pixels > 250).all(axis=2), 1, constant_values=True)
    edges = np.diff(np.pad(paper, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    begins, ends = np.argwhere(edges == 1), np.argwhere(edges == -1)
    runs = [(y, x, end) for (y, x), (_, end) in zip(begins.tolist(), ends.tolist(), strict=True)]
    rows: dict[int, list[int]] = {}
    spot = [*range(len(runs))]

    def first(k: int) -> int:
        while spot[k] != k:
            k = spot[k]
        return k

    for k, (y, x, end) in enumerate(runs):
        rows.setdefault(y, []).append(k)
        for other in rows.get(y - 1, ()):
            if x < runs[other][2] and runs[other][1] < end:
                spot[first(k)] = first(other)
    places: dict[int, list[Any]] = {}
    for k, (y, x, end) in enumerate(runs):
        places.setdefault(first(k), []).append([(u - 1, y - 1) for u in range(x, end)])
    del places[first(0)]  # what lies outside
    found = [(len(spot), *np.mean(spot, axis=0)) for spot in map(np.concatenate, places.values())]
    return [one for one in sorted(found, reverse=True) if one[0] > 100]


@pytest.mark.parametrize("flip", sampled([False, True], 2))
def test_holes_are_seen_where_they_are_and_not_as_in_a_mirror(flip: bool) -> None:
    """The largest spots are the largest holes; three points give the map from web to paper."""
    still = picture(flip)
    spots = islands(still.pixels)
    assert len(spots) == 3
    web = [HOLES[d] for d in sorted(HOLES, reverse=True)]
    rows = np.array([(x, 200.0 - y if flip else y, 1.0) for x, y in web])
    columns, lines = (np.linalg.solve(rows, [spot[k] for spot in spots]) for k in (1, 2))
    # By hand: a step along x goes right and down, one up the web straight up, in cos(0.45) of it.
    assert columns[0] > 0.5
    assert lines[0] > 0
    assert lines[1] < -0.5
    assert abs(columns[1]) < 0.05 * columns[0]
    assert -lines[1] / columns[0] == pytest.approx(1.0, abs=0.03)  # both by the cosine of 0.45


def test_letters_stand_on_the_faces_that_are_seen() -> None:
    still = picture()
    assert [letter for letter, _, _ in still.letters] == ["v", "o"]
    high, wide, _ = still.pixels.shape
    places = {letter: (x * wide, y * high) for letter, x, y in still.letters}
    assert places["o"][1] < places["v"][1]
    assert all(0 < x < wide and 0 < y < high for x, y in places.values())


def test_no_letter_hides_a_hole() -> None:
    """A hole in the very middle of the web, where the letter would stand."""
    holes = (Hole("v", 200.0, 100.0, 22.0, HERE),)
    part, line = Part("M1", CHANNEL, 400.0, HERE, features=holes), load("beamline-annex")
    job = ReadProgram(post([part], line).text.encode(), line, "job.gcode", "", (part,))
    pieces = [p for p in solids_of(job, bar_made(job)).pieces if p["kind"] == "part"]
    still = still_of(pieces, "vouh", 1600, 500)
    ((_, x, y),) = islands(still.pixels)
    high, wide, _ = still.pixels.shape
    at = next((u * wide, v * high) for letter, u, v in still.letters if letter == "v")
    assert np.hypot(at[0] - x, at[1] - y) > 40


def test_the_paper_has_a_picture_of_each_mark_once() -> None:
    job = program()
    pages = pypdfium2.PdfDocument(io.BytesIO(setup_pdf(content_of(SheetSources(job)))))
    drawn = [one for one in pages[0].get_objects() if one.type == 3]  # images
    assert len(drawn) == 1
    colours = np.array(pages[0].render(scale=1.0).to_pil().convert("RGB")).astype(int)
    steel = (colours[..., 2] > colours[..., 0] + 15) & (colours[..., 2] < 240)
    assert steel.mean() > 0.03
