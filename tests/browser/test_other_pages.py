"""The page of a comparison and that of a profile in a browser."""

from pathlib import Path

import pytest

from tests.browser.conftest import Browser
from tests.runs import call

SAMPLE = Path(__file__).resolve().parents[2] / "samples" / "dstv" / "channel.nc1"


def test_what_is_to_be_seen_of_two_parts_is_chosen(browser: Browser, tmp_path: Path) -> None:
    other, page = tmp_path / "b.nc1", tmp_path / "diff.html"
    other.write_text(SAMPLE.read_text().replace("400.00u     45.00", "400.00u     50.00"))
    call("diff", SAMPLE, other, "-o", page)
    browser.open(page, 390)
    seen = "return document.querySelector('.pictures circle.gone').checkVisibility()"
    assert browser.run(seen)
    browser.click("[data-shows=gone]")
    assert not browser.run(seen)
    assert browser.run("return document.documentElement.scrollWidth") <= 390
    assert browser.complaints == []
    assert browser.requests == [page.as_uri()]


def test_a_carriage_moves_as_its_profile_says(browser: Browser, tmp_path: Path) -> None:
    page = tmp_path / "move.html"
    words = "profile --distance 500 --time 4 --jerk 100 -o"
    assert call(*words.split(), page).exit_code == 0
    browser.open(page)
    for time, place in ((0.0, 0.0), (1.0, 500 / 12), (2.0, 250.0), (4.0, 500.0)):
        browser.run("Sheet.go(arguments[0])", time)
        shown = float(browser.run("return document.getElementById('axis-0').value"))
        # The first quarter is v = 250 t^2 / 2 mm/s: its way is a twelfth of it all.
        assert shown == pytest.approx(place, abs=0.001)
    assert browser.complaints == []
    assert browser.requests == [page.as_uri()]
