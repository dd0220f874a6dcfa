"""What a new user meets first: `beamcam` alone, `doctor`, the extras, the page of refused files."""

import json
import re
from pathlib import Path

import pytest

from beamcam.cli import COMMANDS
from beamcam.commands import doctor
from beamcam.commands.codes import all_rules
from beamcam.errors import Severity
from tests import new_user
from tests.conftest import ROOT
from tests.runs import call

REFUSED = (ROOT / "docs" / "refused.md").read_text(encoding="utf-8")
RULES = {rule.code: rule for rule in all_rules()}


def test_beamcam_alone_says_what_to_do_first() -> None:
    done = call(status=0)
    for line in done.stdout.splitlines():
        assert len(line) <= 100
    shown = re.findall(r"^  beamcam (\w+)", done.stdout, re.MULTILINE)
    assert shown[0] == "inspect"
    assert {"post", "batch", "doctor"} <= set(shown) <= set(COMMANDS)


def test_doctor_finds_nothing_wrong_here() -> None:
    call("doctor", status=0)
    findings = {one["what"]: one for one in json.loads(call("doctor", "--json").stdout)}
    assert {one["state"] for one in findings.values()} <= {"ok", "missing"}
    for what in ("a beam", "a drawing"):
        assert "posted and read back" in findings[what]["text"]
    assert "looked for beamcam.toml here and above" in findings["configuration"]["text"]


def test_doctor_tells_the_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "jobs").mkdir()
    monkeypatch.chdir(tmp_path / "jobs")
    path = tmp_path / "beamcam.toml"
    path.write_text("jobs = 2\n")
    assert str(path) in call("doctor").stdout
    path.write_text("\njobs = 'two'\n")
    done = call("doctor", status=1)
    assert f"fault    {path}:2: error config-value" in done.stdout


def test_doctor_tells_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    known = doctor._version
    missing = ("distributed", "shapely")
    monkeypatch.setattr(doctor, "_version", lambda name: "" if name in missing else known(name))
    done = call("doctor", status=1)
    lines = done.stdout.splitlines()
    assert any(re.match(r"shapely +fault ", line) for line in lines)
    (extra,) = (line for line in lines if line.startswith("extra dask"))
    assert extra.endswith("missing  batches on a cluster: pip install 'beamcam[dask]'")


def test_doctor_tells_what_does_not_work(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> int:
        raise ImportError("libgeos is not there")

    monkeypatch.setattr(doctor, "_posted", broken)
    done = call("doctor", status=1)
    assert "fault    ImportError: libgeos is not there" in done.stdout


def test_the_extras_are_those_of_the_project() -> None:
    project = {name: packages for name, packages in new_user.extras().items() if name != "dev"}
    named = {extra: packages for extra, (_, packages) in doctor.EXTRAS.items()}
    assert {name: [re.split(r"[>=]", p)[0] for p in ps] for name, ps in project.items()} == {
        name: list(packages) for name, packages in named.items()
    }
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for extra in (*project, "dev"):
        assert f"`{extra}`" in readme.partition("## Extras")[2]


def codes_of(page: str) -> list[str]:
    rows = (row for row in page.splitlines() if row.startswith("| `"))
    return [code for row in rows for code in re.findall(r"`([^`]+)`", row.split("|")[1])]


def test_the_page_of_refused_files_names_codes_that_refuse() -> None:
    codes = codes_of(REFUSED)
    assert len(codes) == len(set(codes)) > 80
    for code in codes:
        assert RULES[code].severity is Severity.ERROR, code


def test_every_code_that_refuses_stands_on_the_page() -> None:
    refusing = {code for code, rule in RULES.items() if rule.severity is Severity.ERROR}
    assert refusing - set(codes_of(REFUSED)) == set()


def test_what_the_page_advises_is_there() -> None:
    """Options and commands that it names are those of the commands."""
    from tests.test_docs import WORDS

    options = {
        opt
        for command in WORDS.values()
        for p in command.params
        for opt in (*p.opts, *p.secondary_opts)
    }
    for option in re.findall(r"(?<![\w-])--[a-z][a-z-]+", REFUSED):
        assert option in options, option
    for name in re.findall(r"`(?:beamcam )?(doctor|list|diff|check|plot|inspect)\b", REFUSED):
        assert name in COMMANDS
