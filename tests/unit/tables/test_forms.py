"""Each form of a step table through the command line: written, read back, and told from another."""

from pathlib import Path

import pytest

from beamcam.checks.steps import FORMS
from tests.runs import call

from .shop import SAMPLES


@pytest.mark.parametrize("form", FORMS)
def test_a_form_is_verified_against_its_part(form: str, tmp_path: Path) -> None:
    own, other = (str(SAMPLES / f"{name}.json") for name in ("shield-small", "shield"))
    table = str(tmp_path / f"table{form}")
    call("post", own, "-o", table, status=0)
    assert call("verify", table, "--against", own).exit_code == 0
    refused = call("verify", table, "--against", other, status=1)
    assert "error steps-place: found the head at X" in refused.output


@pytest.mark.parametrize("form", FORMS)
def test_a_form_that_was_changed_is_refused(form: str, tmp_path: Path) -> None:
    own, table = str(SAMPLES / "shield-small.json"), tmp_path / f"table{form}"
    assert call("post", own, "-o", table).exit_code == 0
    table.write_bytes(table.read_bytes()[:-30])
    run = call("verify", table, "--against", own, status=1)
    assert "error steps-" in run.output
