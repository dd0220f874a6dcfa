"""Real parts: what a machine can make of them is read back without a word."""

from pathlib import Path

import pytest

from beamcam.checks.bars import verify
from beamcam.checks.rules import LEFT_OUT, MANUAL_WORK, TEXT_MOVED
from beamcam.errors import PlanError, ReadError, errors_in
from beamcam.machine import load
from beamcam.model.plan import SKIP_NAMES
from beamcam.model.request import Request
from beamcam.pipeline import parts_of, post, read_file
from beamcam.solid.opinion import solid_faults
from tests.conftest import CORPUS

FILES = sorted((CORPUS / "dstv").glob("*/*.[nN][cC]*"))
#: Told of what is made too: a text has no room where it is asked for.
NOT_MADE = (LEFT_OUT.code, MANUAL_WORK.code, TEXT_MOVED.code)
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")

pytestmark = pytest.mark.third_party


def planned(name: str) -> list[tuple[Path, str, str]]:
    """Files that can be planned, each with its program and what the read-back says of it."""
    machine, found = load(name), []
    for path in FILES:
        try:
            parts, _ = parts_of([read_file(str(path))])
            posted = post(parts[:1], machine, bar=15500.0, skips=SKIP_NAMES, verified=False)
        except (ReadError, PlanError):
            continue
        told = verify(posted.text, parts[:1], machine, SKIP_NAMES, bar=15500.0)
        said = [str(one) for one in told if one.code not in NOT_MADE]
        found.append((path, posted.text, "\n".join(said)))
    return found


@pytest.mark.parametrize("name", MACHINES)
def test_real_parts_are_read_back(name: str) -> None:
    found = planned(name)
    assert len(found) >= 5
    for path, _, said in found:
        assert said == "", path.name


def test_solids_of_real_parts_agree_with_programs_of_copers() -> None:
    made = []
    for name in ("coper-linuxcnc", "tube-linuxcnc"):
        machine = load(name)
        for path in FILES:
            try:
                parts, _ = parts_of([read_file(str(path))])
                posted = post(parts[:1], machine, skips=SKIP_NAMES, verified=False)
            except (ReadError, PlanError):
                continue
            made.append(path.name)
            said = solid_faults(posted.text, Request((parts[0],), machine, SKIP_NAMES))
            codes = {one.code for one in errors_in(said)}
            assert codes == set(), path.name
    assert "0008-SE0008.nc1" in made


def test_a_web_too_deep_for_the_machines_stroke_is_refused() -> None:
    (path,) = (path for path in FILES if path.name == "HEB400.nc")
    parts, _ = parts_of([read_file(str(path))])
    with pytest.raises(PlanError) as caught:
        post(parts[:1], load("beamline-annex"), bar=15500.0)
    assert "plan-stroke" in {d.code for d in caught.value.diagnostics}
