"""The page of a batch in a browser: filter, order, sheets, a phone."""

from pathlib import Path

import pytest

from tests.browser.conftest import Browser
from tests.conftest import SAMPLES
from tests.runs import call


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    inputs = [str(SAMPLES / "dstv" / f"{n}.nc1") for n in ("channel", "tie", "gusset", "purlin")]
    call("batch", *inputs, "-o", folder / "out", "--report", folder / "r.html")
    return folder / "r.html"


def shown(browser: Browser) -> list[str]:
    found = browser.run(
        "return [...document.querySelectorAll('#files tbody tr')].filter((r) => !r.hidden)"
        ".map((r) => r.cells[0].textContent.split('/').pop())"
    )
    return list(found)


def test_it_is_filtered_and_ordered(browser: Browser, page: Path) -> None:
    browser.open(page)
    assert shown(browser)[0] == "purlin.nc1"
    assert browser.text("shown") == "4 of 4 shown"
    browser.click("#filter")
    browser.keys("UPN200 channel")
    assert shown(browser) == ["channel.nc1"]
    browser.run("const f = document.getElementById('filter'); f.value = '';"
                "f.dispatchEvent(new Event('input'))")  # fmt: skip
    browser.click("#files th button")
    assert shown(browser) == sorted(shown(browser))
    browser.click("#files th button")
    assert shown(browser) == sorted(shown(browser), reverse=True)
    assert browser.complaints == []
    assert browser.requests == [page.as_uri()]


def test_a_link_opens_the_sheet(browser: Browser, page: Path) -> None:
    browser.open(page)
    browser.click("#files a")
    assert browser.run("return document.getElementById('hash').dataset.state") == "same"
    assert browser.complaints == []


def test_a_phone_needs_no_scrolling_sideways(browser: Browser, page: Path) -> None:
    browser.open(page, 390)
    assert browser.run("return document.documentElement.scrollWidth") <= 390


def test_the_head_stays_and_the_totals_hold(browser: Browser, page: Path) -> None:
    browser.open(page)
    browser.run(
        "document.body.style.minHeight = '3000px';"
        "document.querySelector('#files tbody').scrollIntoView()"
    )
    tops = browser.run(
        "return ['header', '#files thead th'].map((s) => document.querySelector(s)"
        ".getBoundingClientRect().top)"
    )
    header = float(browser.run("return document.querySelector('header').offsetHeight"))
    assert tops[0] == 0
    assert 0 <= tops[1] <= header + 1
    rows = browser.run(
        "return [...document.querySelectorAll('.totals section:first-child tr')].slice(1)"
        ".map((r) => [...r.cells].map((c) => c.textContent))"
    )
    machines, whole = rows[:-1], rows[-1]
    assert [row[0] for row in rows] == ["beamline", "plate-linuxcnc", "all"]
    for column in (2, 3):
        assert sum(int(row[column]) for row in machines) == int(whole[column])
    assert float(machines[0][4]) > 3.0  # the channel is 3 m
    tools = browser.run("return document.querySelector('.totals section:last-child').textContent")
    assert "drill 18 (2)" in tools


def test_a_phone_sorts_too(browser: Browser, page: Path) -> None:
    browser.open(page, 390)
    assert shown(browser)[0] == "purlin.nc1"
    browser.click("#files th button")
    assert shown(browser) == sorted(shown(browser))
