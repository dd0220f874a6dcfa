"""Where the samples are, where real files may be, and how golden files are compared."""

import ast
import difflib
import gc
import inspect
import os
import signal
from collections.abc import Generator, Iterable, Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from beamcam.budget import begin_member
from beamcam.errors import Rule

ROOT = Path(__file__).resolve().parent.parent
SAMPLES = ROOT / "samples"
GOLDEN = ROOT / "tests" / "golden"
#: Third-party files are not part of the project. Tests that need them are marked `third_party`, and
#: run where a copy is beside the project or in the folder that the environment names.
THIRD_PARTY = Path(os.environ.get("BEAMCAM_THIRD_PARTY", ROOT.parent / "shared"))
CORPUS = THIRD_PARTY / "corpus"
BEAM_CELL = THIRD_PARTY / "reference" / "beam-cell"


#: The same few examples on every run, so that a failure is the change's; HYPOTHESIS_PROFILE=random
#: looks for new ones, eight times as many. A busy machine is slow at either.
PROFILE = os.environ.get("HYPOTHESIS_PROFILE", "same")
_PATIENT: dict[str, Any] = {
    "deadline": None, "print_blob": True, "suppress_health_check": [HealthCheck.too_slow],
}  # fmt: skip


FEW = 3  #: examples of a law that are always tried


def examples(thorough: int) -> int:
    """How many examples of a law are tried, of so many that are under HYPOTHESIS_PROFILE=random."""
    return thorough if PROFILE == "random" else max(min(thorough, FEW), -(-thorough // 8))


def rules_of(*modules: ModuleType) -> list[Rule]:
    """The rules that modules define, without those that they import."""
    return [
        rule
        for module in modules
        for node in ast.parse(inspect.getsource(module)).body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
        if isinstance(rule := getattr(module, node.targets[0].id), Rule)
    ]


def sampled(cases: Iterable[Any], every: int) -> list[Any]:
    """Cases of a test, of which every so many-th is tried; the others are marked `alike`."""
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)),
            marks=[pytest.mark.alike] * (k % every > 0),
        )
        for k, case in enumerate(cases)
    ]


settings.register_profile("same", derandomize=True, max_examples=examples(100), **_PATIENT)
settings.register_profile("random", **_PATIENT)
settings.load_profile(PROFILE)
if PROFILE == "same":  # else constants of all modules that are loaded are read, and tried
    providers._get_local_constants = cache(providers.Constants)

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


@pytest.hookimpl(tryfirst=True)  # before pytest skips what has no files to be called with
def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("third_party") and not THIRD_PARTY.is_dir():
        pytest.skip(f"no third-party files in {THIRD_PARTY} (BEAMCAM_THIRD_PARTY)")
    begin_member()  # else steps of a reader that a test calls have the time of an earlier test


#: Where tests try one thing in many cases that are alike: laws, mutants, samples on each machine.
ALIKE = tuple(
    f"tests/{f}" for f in (
        "browser/", "property/", "unit/coping/", "unit/setup_sheet/", "unit/sheets/",
        "unit/simulation/", "unit/solid/", "unit/tables/", "unit/checks/test_text_assignment",
        "test_qtplasmac", "test_schemas", "test_settings", "test_systems",
    )
)  # fmt: skip
MANY = 6  #: cases of a test, from which on every third one is tried


@pytest.hookimpl(tryfirst=True)  # before those that are marked are taken out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    cases: dict[str, list[pytest.Item]] = {}
    for item in items:
        marked = {mark.name for mark in item.iter_markers()}
        if item.nodeid.startswith(ALIKE) and not marked & {"alike", "exhaustive"}:
            cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
    for some in cases.values():
        if len(some) >= MANY:
            for item in (item for k, item in enumerate(some) if k % 3):
                item.add_marker(pytest.mark.alike)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is collected lasts, and is not searched for rings; what the tests leave is."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


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
