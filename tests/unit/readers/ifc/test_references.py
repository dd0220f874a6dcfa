"""References that are none are told before the kernel meets them: it would end the process."""

import re
from pathlib import Path

import pytest

from beamcam.geometry.curves import Arc, Line
from beamcam.readers.ifc import Options, kernel, read
from beamcam.readers.ifc.entities import Entity, Unreadable
from beamcam.readers.ifc.kernel import broken_reference, built
from beamcam.readers.ifc.region import Circles, points_of
from tests.conftest import SAMPLES
from tests.unit.readers.ifc.models import Small, opened

SAMPLE = SAMPLES / "ifc" / "beam_openings.ifc"
DATA = SAMPLE.read_bytes()
CHECKED = Options(kernel=True)


@pytest.mark.parametrize("path", sorted((SAMPLES / "ifc").glob("*.ifc")), ids=lambda p: p.stem)
def test_the_samples_have_none(path: Path) -> None:
    file = kernel._kernel().open(str(path))
    for product in file.by_type("IfcElement"):
        if product.Representation is not None:
            assert broken_reference(file, product.Representation) is None


def _solids() -> list[Entity]:
    """The extrusions and booleans of the first beam."""
    beam = opened(DATA).file.by_type("IfcBeam")[0]
    found = beam.below()
    return [e for e in found if e.is_a("IfcSweptAreaSolid") or e.is_a("IfcBooleanResult")]


@pytest.mark.parametrize(
    "instead",
    [
        b"#999998",
        *(pytest.param(one, marks=pytest.mark.exhaustive) for one in (b"$", b"#-31", b"#1")),
    ],
)
def test_each_reference_of_a_solid(instead: bytes) -> None:
    """Gone, to nothing, no reference at all, and to what is no geometry."""
    for solid in _solids():
        name = solid.name.encode()
        line = re.search(rb"(?m)^%s *=.*$" % name, DATA)
        assert line is not None
        for reference in re.finditer(rb"(?<=[(,])#\d+", line[0]):
            begin, end = (line.start() + at for at in reference.span())
            broken = DATA[:begin] + instead + DATA[end:]
            beam = opened(broken).file.by_type("IfcBeam")[0]
            with pytest.raises((Unreadable, LookupError, ValueError)):
                built(opened(broken), beam)
            found = read(broken, "broken.ifc", options=CHECKED)
            assert beam.GlobalId not in {part.guid for part in found.parts}


@pytest.mark.parametrize("instead", [b"#1", b"$", b"(1.,0.)", b"5", b".T.", b"()"])
@pytest.mark.parametrize("sample", ["beam_openings", "bolted"])
def test_what_is_named_by_no_text_is_named_by_its_record(sample: str, instead: bytes) -> None:
    data = (SAMPLES / "ifc" / f"{sample}.ifc").read_bytes()
    kinds = rb"(=IFC(?:BEAM|OPENINGELEMENT|MECHANICALFASTENER)\()'[^']*'"
    changed, count = re.subn(kinds, lambda found: found[1] + instead, data)
    assert count > 1
    reading = read(changed, "m.ifc")
    names = [feature.source.where for part in reading.parts for feature in part.features]
    names += [said.source.where for said in reading.diagnostics]
    assert all(name is None or isinstance(name, str) for name in names)
    assert all(part.guid.startswith("#") for part in reading.parts)


@pytest.mark.parametrize("values", ["$", "", "'a'", "(1.,$,0.)", "(.T.,#1)", "*"])
def test_points_without_numbers(values: str) -> None:
    for kind in (b"IFCCARTESIANPOINT", b"IFCDIRECTION"):
        broken = re.sub(kind + rb"\([^;]*\);", kind + b"(%s);" % values.encode(), DATA)
        found = read(broken, "broken.ifc")
        assert found.refused
        assert found.diagnostics


def test_a_property_that_is_not_there_costs_no_member() -> None:
    m = Small()
    beam = m.element(m.extruded(m.ipe300(), 1000.0))
    m.properties(beam, "Tekla Common", Reference="IFCLABEL('B7')", Other="IFCLABEL('x')")
    data = m.data
    for broken in (
        re.sub(rb"#\d+=IFCPROPERTYSINGLEVALUE\('Other'[^;]*;", b"", data),
        data.replace(b"('Other',$,IFCLABEL('x'),$)", b"('Other',$,,IFCLABEL('x')"),
    ):
        assert broken != data
        assert read(broken, "m.ifc").parts == read(data, "m.ifc").parts != ()


def test_a_quote_without_another_refuses_the_file() -> None:
    broken = DATA.replace(b"IFCPROJECT('", b"IFCPROJECT(")
    (said,) = read(broken, "m.ifc").diagnostics
    assert said.code == "ifc-syntax"


def test_an_arc_of_a_huge_circle() -> None:
    assert len(points_of((Arc((0.0, 0.0), 10_000.0, 0.0, 360.0),), Circles())) < 20_000
    wide = Arc((0.0, -1e9), 1e9, 90.0, -1e-6)
    assert len(points_of((wide, Line(wide.end, wide.start)), Circles())) < 100
    for radius in (1e6, 1e9, 1e14, 1e300):
        with pytest.raises(Unreadable, match="radius"):
            points_of((Arc((0.0, 0.0), radius, 0.0, 360.0),), Circles())
