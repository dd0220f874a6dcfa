"""What is said about a part that lies on the bar as no turn of the part that was given."""

from beamcam.machine import load
from beamcam.model.part import Part
from beamcam.pipeline import post
from beamcam.verify import verify
from tests.strategies import BEAM, SOURCE


def test_the_read_back_says_so() -> None:
    part = Part("A", BEAM, 1500.0, SOURCE)
    other = Part("A", BEAM, 1501.0, SOURCE)
    machine = load("beamline")
    text = post([part], machine).text
    assert verify(text, [part], machine, given=[part]) == ()
    assert [str(said) for said in verify(text, [part], machine, given=[other])] == [
        "random.nc1:1: error verify-turned: found A lying as no turn of the part that was given; "
        "expected one of its eight"
    ]
