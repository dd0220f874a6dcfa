"""Geometry that contains itself never reaches the kernel, which would take the process with it."""

from pathlib import Path

import pytest

from beamcam.readers.ifc import Options, read
from tests.conftest import SAMPLES

MODEL = SAMPLES / "ifc" / "beam_openings.ifc"


def entities(path: Path):
    ifcopenshell = pytest.importorskip("ifcopenshell")
    return ifcopenshell.open(str(path))


def test_a_model_as_it_should_be() -> None:
    from beamcam.readers.ifc.kernel import contains_itself

    model = entities(MODEL)
    assert not any(contains_itself(beam) for beam in model.by_type("IfcBeam"))


def test_a_boolean_of_itself_is_seen() -> None:
    from beamcam.readers.ifc.kernel import contains_itself

    model = entities(MODEL)
    beam = model.by_type("IfcBeam")[0]
    shape = beam.Representation.Representations[0]
    loop = model.create_entity("IfcBooleanResult", "DIFFERENCE", shape.Items[0], shape.Items[0])
    loop.FirstOperand = loop
    shape.Items = [loop]
    assert contains_itself(beam)
    found = read(model.to_string().encode(), "loop.ifc", options=Options(kernel=True))
    codes = [d.code for d in found.diagnostics if d.source.where == beam.GlobalId]
    assert codes
    assert beam.GlobalId not in {part.guid for part in found.parts}
