"""Where the samples are, where real files may be, and how golden files are compared."""

import difflib
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
SAMPLES = ROOT / "samples"
GOLDEN = ROOT / "tests" / "golden"
#: Third-party files are not part of the project; tests over them run where a copy is at hand.
SHARED = ROOT.parent / "shared"
CORPUS = Path(os.environ.get("BEAMCAM_CORPUS", SHARED / "corpus"))


#: The same examples on every run, so that a failure is the change's; HYPOTHESIS_PROFILE=random
#: looks for new ones.
settings.register_profile("same", derandomize=True, deadline=None, print_blob=True)
settings.register_profile("random", deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

# A shell has what it starts in the background ignore Ctrl-C, and commands started from here would
# do the same.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="session")
def no_user_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No configuration and no machines of the user who runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("XDG_CONFIG_HOME", "APPDATA"):
            patch.setenv(name, str(tmp_path_factory.getbasetemp() / "no-user"))
        patch.delenv("FORCE_COLOR", raising=False)
        yield


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="Write the golden files anew; read the diff."
    )


class Golden:
    """Compares a text with a golden file, or writes it under `--update-golden`."""

    def __init__(self, update: bool) -> None:
        self.update = update

    def check(self, path: Path, text: str) -> None:
        if self.update:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            return
        expected = path.read_text(encoding="utf-8") if path.exists() else ""
        if expected != text:
            lines = difflib.unified_diff(
                expected.splitlines(), text.splitlines(), str(path.name), "now", lineterm=""
            )
            pytest.fail("\n".join(lines), pytrace=False)


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Golden:
    return Golden(bool(request.config.getoption("--update-golden")))
