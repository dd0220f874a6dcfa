"""Openings that an assembly has for its members, and steel that a projection adds to one."""

import pytest

from beamcam.errors import Severity
from beamcam.model.part import Hole
from beamcam.readers.ifc import Options, read
from tests.unit.readers.ifc.models import Small


def opened_assembly(levels: int, schema: str) -> bytes:
    """A beam in an assembly in an assembly, and a hole in the outermost one."""
    m = Small(schema)
    inner = m.element(m.extruded(m.ipe300(), 2000.0))
    for _ in range(levels):
        last = ",$,.FACTORY.,.USERDEFINED." if schema != "IFC2X3" else ",.FACTORY.,.USERDEFINED."
        tag = "" if schema != "IFC2X3" else ",'A'"
        whole = m.add(
            f"IFCELEMENTASSEMBLY('{m.step.guid()}',{m.step.owner},'A',$,$,{m.placement},$"
            f"{tag}{last})"
        )
        m.add(f"IFCRELAGGREGATES('{m.step.guid()}',{m.step.owner},$,$,{whole},({inner}))")
        inner = whole
    feature(m, inner, m.hole((500, -40, 0), (0, 1, 0), 18.0, 80.0), "Opening", "Voids")
    return m.data


def feature(m: Small, element: str, solid: str, kind: str, relation: str) -> None:
    shape = m.add(f"IFCSHAPEREPRESENTATION({m.step.context},'Body','SweptSolid',({solid}))")
    product = m.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
    last = ",$" if m.step.schema != "IFC2X3" else ""
    made = m.add(
        f"IFC{kind.upper()}ELEMENT('{m.step.guid()}',{m.step.owner},$,$,$,{m.placement},"
        f"{product},${last})"
    )
    m.add(f"IFCREL{relation.upper()}ELEMENT('{m.step.guid()}',{m.step.owner},$,$,{element},{made})")


@pytest.mark.parametrize("levels", [0, 1, 2])
@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4"])
def test_an_opening_of_an_assembly_goes_through_its_members(levels: int, schema: str) -> None:
    found = read(opened_assembly(levels, schema), "m.ifc", options=Options(kernel=True))
    assert not [d for d in found.diagnostics if d.severity is not Severity.NOTE]
    (part,) = found.parts
    (hole,) = part.features
    assert isinstance(hole, Hole)
    assert (hole.face, hole.x, hole.y, hole.diameter) == ("v", 500.0, 150.0, 18.0)


def with_a_projection() -> bytes:
    m = Small()
    beam = m.element(m.extruded(m.ipe300(), 2000.0))
    plate = m.extruded(m.box(140, 270), 10.0, m.step.axes((900, 0, 0), (1, 0, 0), (0, 1, 0)))
    feature(m, beam, plate, "Projection", "Projects")
    return m.data


def test_a_projection_refuses_the_member_unless_it_is_forced() -> None:
    found = read(with_a_projection(), "m.ifc")
    assert not found.parts
    assert [d.code for d in found.diagnostics] == ["ifc-projection", "ifc-ledger"]
    forced = read(with_a_projection(), "m.ifc", options=Options(force=True))
    assert len(forced.parts) == 1
    (said,) = [d for d in forced.diagnostics if d.code == "ifc-projection"]
    assert said.severity is Severity.WARNING
