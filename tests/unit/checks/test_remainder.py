"""The remainder of a program behind what was done before it: each fault is found at its line."""

import re

import pytest

from beamcam.checks.bars import run
from beamcam.machine import load
from beamcam.model.request import Request
from beamcam.pipeline import post, whole_job
from beamcam.readers import read
from beamcam.remainder import faults_of, rest_of
from tests.conftest import SAMPLES

CHANNEL = SAMPLES / "dstv" / "channel.nc1"
PARTS = read(CHANNEL.read_bytes(), "channel.nc1").parts
JOB = whole_job(Request(PARTS, load("beamline"), name="rest.gcode"))
POSTED = post(PARTS, JOB.machine, "rest.gcode")


def said(rest: str, first: int, whole: str = POSTED.text) -> list[str]:
    return [str(one) for one in faults_of(rest, whole, first, JOB)]


@pytest.mark.parametrize("machine", ["beamline", "beamline-annex", "beamline-pusher"])
def test_operations_are_counted_as_they_were_planned(machine: str) -> None:
    loaded = load(machine)
    posted = post(PARTS, loaded)
    made = run(posted.text, loaded, PARTS[0].profile).made
    assert len({one.line for one in made.order}) == len(posted.plan.operations)


def test_an_operation_that_the_whole_program_has_not() -> None:
    rest = rest_of(POSTED, 8).text
    assert said(rest, 99) == [
        "whole program: error verify-operation: found operation 99 to begin with; expected 2 to "
        "12, as `beamcam plan` counts"
    ]


@pytest.mark.parametrize(
    ("pattern", "to", "code"),
    [
        (r"(G00 X)(\d+)", r"\g<1>9\2", "verify-hole|verify-stop-back"),
        (r"M08\n", "", "verify-coolant"),
        (r"M03 K\d+\n", "", "verify-syntax|verify-spindle-off"),
        (r"F\d+(\.\d+)?", "F9000", "verify-feed-limit"),
    ],
)
def test_a_fault_of_the_remainder_stands_at_its_line(pattern: str, to: str, code: str) -> None:
    rest = rest_of(POSTED, 8).text
    assert said(rest, 8) == []
    broken = re.sub(pattern, to, rest, count=1)
    assert broken != rest
    found = said(broken, 8)
    assert any(re.match(rf"rest\.gcode:\d+: error ({code})", one) for one in found), found


def test_the_remainder_has_to_follow_what_was_done() -> None:
    rest = rest_of(POSTED, 8).text
    assert any("verify-hole-extra" in one for one in said(rest, 9))
    assert any("verify-hole-missing" in one for one in said(rest, 7))
    other = POSTED.text.replace("L18", "L22")
    assert said(rest, 8, other) != []
