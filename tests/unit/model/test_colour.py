"""Colours by name, by hue, and what a table makes of them."""

from math import inf

import pytest

from beamcam.errors import Source
from beamcam.geometry.curves import Line
from beamcam.model.colour import (
    NAMES,
    colour_name,
    hue_deg,
    hue_distance_deg,
    nearest_colour,
    parse_colour,
    process_of,
)
from beamcam.model.part import Contour

TABLE = ("red", "blue", "black", "lime", "aqua", "yellow", "magenta", "white")


@pytest.mark.parametrize(
    ("text", "colour"),
    [
        ("#F00", "#ff0000"),
        ("#Ed3237", "#ed3237"),
        (" Red ", "#ff0000"),
        ("aliceblue", "#f0f8ff"),
        ("rebeccapurple", "#663399"),
        ("rgb(255, 0,128)", "#ff0080"),
        ("RGB(100% 0% 50%)", "#ff0080"),
        ("rgba(0,0,255,0.5)", "#0000ff"),
        ("rgb(300, -5, 0)", "#ff0000"),
    ],
)
def test_parse(text: str, colour: str) -> None:
    assert parse_colour(text) == colour


@pytest.mark.parametrize("text", ["", "#12", "#12345", "reddish", "none", "rgb(1,2)", "rgb(a,b,c)"])
def test_what_is_no_colour(text: str) -> None:
    with pytest.raises(ValueError, match=r"found|could not convert"):
        parse_colour(text)


def test_names_are_those_of_css() -> None:
    assert len(NAMES) == 148
    assert all(parse_colour(value) == value for value in NAMES.values())
    assert NAMES["grey"] == NAMES["gray"] == "#808080"
    assert colour_name("#ff0000") == "red"
    assert colour_name("#ed3237") == "#ed3237"


def test_hues() -> None:
    hues = {"red": 0, "yellow": 60, "lime": 120, "aqua": 180, "blue": 240, "magenta": 300}
    assert {name: hue_deg(parse_colour(name)) for name in hues} == hues
    assert hue_distance_deg("#ff0000", "#ff00ff") == 60
    assert hue_distance_deg("#000000", "#1f1a17") == 0
    assert hue_distance_deg("#000000", "#ff0000") == inf
    assert hue_distance_deg("#000000", "#ffffff") == inf
    assert hue_distance_deg("#ffc0cb", "#ff0000") == inf  # pink is too pale to be red
    assert hue_distance_deg("#ffc0cb", "#ffc0cb") == 0


@pytest.mark.parametrize(
    ("colour", "expected"),
    [
        ("#ed3237", "red"),  # what CMYK conversions of CorelDRAW make of the primaries
        ("#ed1c24", "red"),
        ("#1f1a17", "black"),
        ("#373435", "black"),
        ("#2b2a29", "black"),
        ("#00a0e3", "aqua"),
        ("#3e4095", "blue"),
        ("#fff212", "yellow"),
        ("#fefefe", "white"),
        ("#00ff00", "lime"),
        ("#ff8000", None),  # orange lies between red and yellow
        ("#808080", None),
        ("#ffc0cb", None),
    ],
)
def test_the_nearest_colour(colour: str, expected: str | None) -> None:
    assert nearest_colour(colour, TABLE) == expected


def test_an_equal_colour_wins_and_a_draw_is_none() -> None:
    assert nearest_colour("#ed3237", ("red", "#ED3237")) == "#ED3237"
    assert nearest_colour("#ff0000", ("#ff1100", "#ff0011")) is None
    assert nearest_colour("#ff0000", ("#fe0000", "maroon")) is None
    assert nearest_colour("#ed3237", ("red", "#f00")) == "red"  # one colour, named twice
    assert nearest_colour("#ff0000", ()) is None


def contour(layer: str | None, colour: str | None) -> Contour:
    return Contour("v", "open", (Line((0, 0), (1, 0)),), Source("a"), layer=layer, colour=colour)


@pytest.mark.parametrize(
    ("layer", "colour", "process"),
    [
        ("Score", "#ff0000", "mark"),  # the layer decides before the colour
        ("SCORE", None, "mark"),
        ("0", "#ed3237", "cut"),
        (None, "#0000fe", "punch"),
        ("0", "#123456", None),
        (None, None, None),
        ("blue", None, "punch"),  # a layer may be called like a colour
    ],
)
def test_processes(layer: str | None, colour: str | None, process: str | None) -> None:
    table = {"score": "mark", "red": "cut", "Blue": "punch", "#000": "engrave"}
    assert process_of(contour(layer, colour), table) == process  # type: ignore[arg-type]
