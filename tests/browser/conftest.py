"""A headless Chromium, one for each worker that asks for it."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import SAMPLES
from tests.runs import call

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")


class Browser:
    """A browser with one page open at a time; what it asks for and complains of is kept."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def open(self, page: Path | str, width: int = 1200, height: int = 900) -> None:
        """A page from the disk or at an address, with nothing logged before."""
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )
        self.driver.get("about:blank")
        self.driver.get_log("browser"), self.driver.get_log("performance")
        self.driver.get(page if isinstance(page, str) else page.as_uri())
        # A solid is unpacked in its own time.
        self.driver.execute_async_script(
            "const done = arguments[0]; (async () => {"
            "if (typeof Sheet !== 'undefined') await Sheet.ready; done(); })()"
        )

    def run(self, script: str, *arguments: object) -> Any:
        """What a script in the page returns."""
        return self.driver.execute_script(script, *arguments)

    def text(self, identity: str) -> str:
        """The text of an element."""
        return str(self.run("return document.getElementById(arguments[0]).textContent", identity))

    def click(self, selector: str) -> None:
        """A click by the mouse on the first element of a selector."""
        self.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", selector)
        self.driver.find_element("css selector", selector).click()

    def keys(self, text: str) -> None:
        """Keys typed in the page."""
        from selenium.webdriver import ActionChains

        ActionChains(self.driver).send_keys(text).perform()

    @property
    def complaints(self) -> list[str]:
        """What stands in the console, but for what a slow driver of graphics says of its speed."""
        found = [entry["message"] for entry in self.driver.get_log("browser")]
        return [said for said in found if "GL Driver Message (OpenGL, Performance" not in said]

    @property
    def requests(self) -> list[str]:
        """The addresses that the page asked for, itself among them."""
        found = [json.loads(entry["message"])["message"]
                 for entry in self.driver.get_log("performance")]  # fmt: skip
        urls = [m["params"]["request"]["url"] for m in found
                if m["method"] == "Network.requestWillBeSent"]  # fmt: skip
        return [url for url in urls if not url.startswith("data:")]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A browser for all tests."""
    if CHROMIUM is None or DRIVER is None:
        pytest.skip("chromium and chromedriver are not installed (Debian: chromium-driver)")
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    options = Options()
    options.binary_location = CHROMIUM
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                     "--enable-unsafe-swiftshader", "--lang=en-US"):  # fmt: skip
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    try:
        yield Browser(driver)
    finally:
        driver.quit()


def mouse(browser: Browser, kind: str, x: float, y: float, **more: Any) -> None:
    browser.driver.execute_cdp_cmd(
        "Input.dispatchMouseEvent",
        {"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1, **more},
    )


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Setup sheets of a bar of three parts and of a plate."""
    made = tmp_path_factory.mktemp("sheets")
    for name, inputs, machine in (
        ("bar", ("channel", "tie", "channel"), "beamline-annex"),
        ("plate", ("gusset",), "plate-linuxcnc"),
    ):
        words = [
            "report",
            *(str(SAMPLES / "dstv" / f"{one}.nc1") for one in inputs),
            "--machine",
            machine,
        ]
        call(*words, "-o", made / f"{name}.html", status=0)
    return made
