"""Geometry that contains itself never reaches the kernel, which would take the process with it."""

import re

import pytest

from beamcam.readers.ifc import Options, read
from tests.conftest import SAMPLES
from tests.unit.readers.ifc.models import opened

DATA = (SAMPLES / "ifc" / "beam_openings.ifc").read_bytes()


def test_a_model_as_it_should_be() -> None:
    beams = opened(DATA).file.by_type("IfcBeam")
    assert beams
    assert all(beam.below()[-1] is beam for beam in beams)


def test_a_boolean_of_itself_is_seen() -> None:
    beam = opened(DATA).file.by_type("IfcBeam")[0]
    shape = beam.Representation.Representations[0]
    item = shape.Items[0].name.encode()
    # The shape's item becomes a boolean whose first operand is the boolean.
    record = shape.name.encode()
    loop = b"#999999=IFCBOOLEANRESULT(.DIFFERENCE.,#999999,%s);" % item
    head, line = re.search(rb"(?m)^(%s *= *.*)\(%s\)\);" % (record, item), DATA).group(1, 0)
    data = DATA.replace(line, head + b"(#999999));\n" + loop)
    beam = next(e for e in opened(data).file.by_type("IfcBeam") if e.GlobalId == beam.GlobalId)
    with pytest.raises(RecursionError, match="contains itself"):
        beam.below()
    found = read(data, "loop.ifc", options=Options(kernel=True))
    assert [d.code for d in found.diagnostics if d.source.where == beam.GlobalId]
    assert beam.GlobalId not in {part.guid for part in found.parts}


@pytest.mark.parametrize("through", ["", "an assembly"])
def test_an_assembly_of_itself_is_seen(through: str) -> None:
    """The kernel goes up from a part to its assembly for as long as there is one."""
    beam = opened(DATA).file.by_type("IfcBeam")[0]
    rows = f"#999990=IFCRELAGGREGATES('x',$,$,$,{beam.name},({beam.name}));"
    if through:
        rows = (
            "#999989=IFCELEMENTASSEMBLY('y',$,'A',$,$,$,$,'A2',.FACTORY.,.USERDEFINED.);"
            f"#999990=IFCRELAGGREGATES('x',$,$,$,{beam.name},(#999989));"
            f"#999991=IFCRELAGGREGATES('z',$,$,$,#999989,({beam.name}));"
        )
    end = DATA.rindex(b"ENDSEC;")
    data = DATA[:end] + rows.encode() + b"\n" + DATA[end:]
    found = read(data, "loop.ifc", options=Options(kernel=True))
    said = [str(d) for d in found.diagnostics if d.source.where == beam.GlobalId]
    assert any("an assembly that contains itself" in one for one in said), said
