"""CorelDRAW exports against what a browser engine measures, and against svgelements."""

import json

import pytest

from beamcam.errors import errors_in
from beamcam.model.colour import parse_colour
from beamcam.model.lengths import total_length
from beamcam.model.part import extent
from beamcam.readers import svg
from tests.conftest import CORPUS

FOLDER = CORPUS / "svg"
TRUTH = json.loads((FOLDER / "truth.json").read_text())["files"] if FOLDER.exists() else {}
USABLE = sorted(name for name, truth in TRUTH.items() if truth["usable"])

pytestmark = pytest.mark.third_party


def read(name: str):
    return svg.read((FOLDER / name).read_bytes(), name)


def turned_up(box: list[float], height: float) -> tuple[float, ...]:
    x0, y0, x1, y1 = box
    return x0, height - y1, x1, height - y0


def close(length: float):
    """The browser says lengths to 0.001 mm, an element each, and flattens a little."""
    return pytest.approx(length, rel=1e-5, abs=2e-3)


@pytest.mark.parametrize("name", USABLE)
def test_lengths_are_those_of_the_browser(name: str) -> None:
    truth, reading = TRUTH[name], read(name)
    assert errors_in(reading.diagnostics) == ()
    (part,) = reading.parts
    assert part.measures is not None
    stroked = total_length(c for contour in part.contours for c in contour.curves)
    assert stroked == close(truth["stroked_length_mm"])
    seen = stroked + total_length(part.measures.filled) + total_length(part.measures.hidden)
    # The browser's round corners of rectangles are some 1e-4 of their length off.
    assert seen == pytest.approx(truth["length_mm"], rel=1e-4)
    assert dict(part.measures.not_cut).get("text", 0) == truth["n_text"]


@pytest.mark.parametrize("name", USABLE)
def test_boxes_are_those_of_the_browser(name: str) -> None:
    truth = TRUTH[name]
    (part,) = read(name).parts
    height = truth["page_mm"][1]
    curves = [c for contour in part.contours for c in contour.curves]
    if truth["stroked_bbox_mm"] is None:
        assert curves == []
    else:
        expected = turned_up(truth["stroked_bbox_mm"], height)
        assert extent(curves) == pytest.approx(expected, abs=1e-3)
    assert part.measures is not None
    if not truth["n_invisible"]:
        expected = turned_up(truth["bbox_mm"], height)
        assert extent([*curves, *part.measures.filled]) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("name", USABLE)
def test_lengths_by_colour(name: str) -> None:
    by_colour: dict[str, list] = {}
    for contour in next(iter(read(name).parts)).contours:
        by_colour.setdefault(contour.colour or "", []).extend(contour.curves)
    expected = {
        parse_colour(colour): stroke["length_mm"]
        for colour, stroke in TRUTH[name]["stroked_by_colour"].items()
    }
    assert set(by_colour) == set(expected)
    for colour, curves in by_colour.items():
        assert total_length(curves) == close(expected[colour])
