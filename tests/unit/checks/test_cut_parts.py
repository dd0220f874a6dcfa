"""Programs of a line without a saw, whose parts come in cut."""

from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.errors import errors_in
from beamcam.machine import load
from beamcam.pipeline import post
from tests.unit.checks.programs import PART


def test_another_part_beside_it() -> None:
    line = replace(load("beamline"), saw=None)
    program = post((PART,), line).text
    assert errors_in(verify(program, (PART,), line)) == ()
    (said,) = errors_in(verify(program, (PART, PART), line))
    assert f": error {said.code}: {said.message}".endswith(
        " verify-no-saw: found the part P1 beside another one; expected one part, the machine has "
        "no saw"
    )
