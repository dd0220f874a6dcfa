"""The sample models: what the builder writes, and what is read of them."""

from random import Random

import pytest

from beamcam.readers import read
from tests.conftest import SAMPLES, Golden
from tests.property.ifc_builder import HoleSpec, Member, model_text
from tests.property.ifc_cuts import Bar, Box, Cuts, Round
from tests.unit.readers.ifc.models import Small

IPE300 = (300.0, 150.0, 10.7, 7.1)
BEAM = Member(
    "I", IPE300, 4000.0, ((0.0, 0.0), (-30.0, 0.0)),
    (
        HoleSpec("v", 60.0, 110.0, 22.0), HoleSpec("v", 60.0, 190.0, 22.0),
        HoleSpec("o", 700.0, 35.0, 18.0, both=True), HoleSpec("o", 700.0, 115.0, 18.0, both=True),
    ),
    16, "B1",
)  # fmt: skip
BRACE = Member("L", (80.0, 60.0, 8.0, 8.0), 1800.0, ((45.0, 0.0), (0.0, 0.0)), (), 16, "D4")


def bolted() -> str:
    """A beam without holes, with the bolts that make them, and a concrete column."""
    m = Small()
    beam = m.element(m.extruded(m.ipe300(), 2500.0), tag="B7", name="IPE300")
    m.material(beam, "STEEL/S355JR")
    m.assembly(beam, "A2")
    for z in (-40.0, 40.0):
        m.bolt((50.0, -20.0, z), (0, 1, 0), 20.0, 45.0)
    column = m.element(m.extruded(m.box(300, 300), 3000.0), "IFCCOLUMN", tag="C1")
    m.material(column, "CONCRETE/C30/37")
    return m.step.text()


def slotted() -> str:
    """A round tube with a slot for a gusset at one end, and a saddle at the other."""
    tube = Bar("RO", 800.0, (88.9, 88.9, 5.0, 5.0, 0.0))
    slot = Box((-10.0, -10.0, 32.45), (90.0, 100.0, 56.45))
    made = Cuts()
    m, chord = made.small, Round((800.0, -100.0, 44.45), 1, 139.7, 300.0)
    brace = m.element(made.body(tube, [slot, chord]), "IFCMEMBER", tag="D7", name="CHS88.9*5")
    m.material(brace, "STEEL/S355J2H")
    return m.step.text()


def texts() -> dict[str, str]:
    def one(encoding: str, *members: Member) -> str:
        return model_text(members, encoding, Random(7))[0]

    return {
        "beam_openings.ifc": one("openings", BEAM, BEAM, BRACE),
        "beam_inch.ifc": one("inch", BEAM),
        "beam_brep.ifc": one("brep", BEAM),
        "bolted.ifc": bolted(),
        "tube_slotted.ifc": slotted(),
    }


@pytest.mark.parametrize("name", sorted(texts()))
def test_sample_is_what_the_builder_writes(name: str, golden: Golden) -> None:
    golden.check(SAMPLES / "ifc" / name, texts()[name])


@pytest.mark.parametrize(
    ("name", "marks", "features"),
    [
        ("beam_openings.ifc", ["B1", "B1", "D4"], [6, 6, 0]),
        ("beam_inch.ifc", ["B1"], [6]),
        ("beam_brep.ifc", ["B1"], [6]),
        ("bolted.ifc", ["B7"], [2]),
        ("tube_slotted.ifc", ["D7"], [1]),
    ],
)
def test_sample_is_read(name: str, marks: list[str], features: list[int]) -> None:
    found = read((SAMPLES / "ifc" / name).read_bytes(), name)
    assert not found.refused
    assert [p.mark for p in found.parts] == marks
    assert [len(p.features) for p in found.parts] == features
