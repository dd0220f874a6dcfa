"""Every code of the reader of models is met by an input that deserves it."""

import io
import zipfile
from collections.abc import Callable

import pytest

from beamcam.errors import Severity
from beamcam.readers.ifc import Options, Selection, looks_like, read
from beamcam.readers.ifc.rules import RULES
from tests.unit.readers.ifc.models import ORIGIN, Small


def plain() -> Small:
    m = Small()
    m.element(m.extruded(m.ipe300(), 2000.0))
    return m


def syntax() -> bytes:
    return b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n"


def schema() -> bytes:
    return plain().data.replace(b"'IFC4'", b"'IFC4X1'")


def no_members() -> bytes:
    return Small().data


def left_out() -> bytes:
    m = plain()
    m.material(m.element(m.extruded(m.box(300, 300), 3000.0), "IFCCOLUMN"), "CONCRETE/C30/37")
    return m.data


def curved() -> bytes:
    m = Small()
    axis = m.add(f"IFCAXIS1PLACEMENT({m.step.point(5000, 0, 0)},{m.step.direction(0, 1, 0)})")
    m.element(m.add(f"IFCREVOLVEDAREASOLID({m.ipe300()},{m.step.world},{axis},0.5)"))
    return m.data


def tapered() -> bytes:
    m = Small()
    up = m.step.direction(0, 0, 1)
    ends = m.box(200, 10), m.box(100, 10)
    m.element(m.add(f"IFCEXTRUDEDAREASOLIDTAPERED({ends[0]},{m.step.world},{up},900.,{ends[1]})"))
    return m.data


def askew() -> bytes:
    """A hole at 20 degrees to the web."""
    m = Small()
    z = (0.0, 0.9396926207859084, 0.3420201433256687)
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.hole((500, -40, -15), z, 18, 80)))
    return m.data


def no_section() -> bytes:
    """A tetrahedron."""
    m = Small()
    p = [m.step.point(*v) for v in (ORIGIN, (900, 0, 0), (0, 300, 0), (0, 0, 300))]
    faces = []
    for a, b, c in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        loop = m.add(f"IFCPOLYLOOP(({p[a]},{p[b]},{p[c]}))")
        faces.append(m.add(f"IFCFACE(({m.add(f'IFCFACEOUTERBOUND({loop},.T.)')}))"))
    shell = m.add(f"IFCCLOSEDSHELL(({','.join(faces)}))")
    m.element(m.add(f"IFCFACETEDBREP({shell})"))
    return m.data


def wrong_name() -> bytes:
    m = Small()
    m.element(m.extruded(m.ipe300(), 2000.0), name="HEB220")
    return m.data


def wrong_length() -> bytes:
    m = Small()
    m.properties(
        m.element(m.extruded(m.ipe300(), 2000.0)),
        "Tekla Quantity",
        Length="IFCLENGTHMEASURE(2100.)",
    )
    return m.data


def wrong_weight() -> bytes:
    m = Small()
    e = m.element(m.extruded(m.ipe300(), 2000.0))
    m.properties(e, "Tekla Quantity", NetWeight="IFCMASSMEASURE(42.)")
    return m.data


def in_two() -> bytes:
    m = Small()
    slit = m.extruded(m.box(30, 400), 400.0, m.step.axes((900, -200, 0), (0, 1, 0), (1, 0, 0)))
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), slit))
    return m.data


def elliptic() -> bytes:
    """A union, which only the kernel reads, with an elliptic hole."""
    m = Small()
    first = m.extruded(m.box(200, 20), 600.0)
    second = m.extruded(m.box(200, 20), 500.0, m.step.axes((600, 0, 0), (1, 0, 0), (0, 1, 0)))
    profile = m.add(f"IFCELLIPSEPROFILEDEF(.AREA.,$,{m.flat},60.,30.)")
    hole = m.extruded(profile, 100.0, m.step.axes((300, 0, -50), (0, 0, 1), (1, 0, 0)))
    m.element(m.minus(m.add(f"IFCBOOLEANRESULT(.UNION.,{first},{second})"), hole))
    return m.data


def bolted() -> bytes:
    m = plain()
    m.bolt((300, -20, 50), (0, 1, 0), 20.0, 60.0)
    return m.data


def with_a_nut() -> bytes:
    """A bolt, a square block and a fastener without geometry."""
    m = Small()
    m.element(m.extruded(m.ipe300(), 2000.0))
    m.bolt((300, -20, 50), (0, 1, 0), 20.0, 60.0)
    for body in (m.extruded(m.box(30, 30), 16.0), None):
        m.element(body, "IFCMECHANICALFASTENER", tag="N")
    return m.data


def bolted_askew() -> bytes:
    m = plain()
    m.bolt((300, -20, 50), (0, 0.9961946980917455, 0.08715574274765817), 20.0, 60.0)
    return m.data


CASES: dict[str, Callable[[], bytes]] = {
    "ifc-syntax": syntax,
    "ifc-schema": schema,
    "ifc-no-members": no_members,
    "ifc-left-out": left_out,
    "ifc-curved": curved,
    "ifc-tapered": tapered,
    "ifc-geometry": askew,
    "ifc-section": no_section,
    "ifc-profile-name": wrong_name,
    "ifc-length": wrong_length,
    "ifc-weight": wrong_weight,
    "ifc-kernel-fitted": elliptic,
    "ifc-pieces": in_two,
    "ifc-bolt-holes": bolted,
    "ifc-bolt-skew": bolted_askew,
    "ifc-bolt-shank": with_a_nut,
    "ifc-bolts": bolted,
    "ifc-ledger": lambda: plain().data,
}
ELSEWHERE = {"ifc-selection", "ifc-kernel", "ifc-kernel-log", "ifc-kernel-denied"}


def test_every_code_has_a_case() -> None:
    assert {r.code for r in RULES} == set(CASES) | ELSEWHERE


@pytest.mark.parametrize("code", CASES)
def test_code_is_said(code: str) -> None:
    found = read(CASES[code](), "model.ifc")
    (said, *_) = [d for d in found.diagnostics if d.code == code]
    rule = next(r for r in RULES if r.code == code)
    assert said.severity is rule.severity
    assert "{" not in said.message
    if rule.severity is Severity.ERROR and code not in ("ifc-syntax", "ifc-schema"):
        assert said.source.where is not None
        assert len(said.source.where) == 22


def test_a_bolt_askew_refuses_its_member_unless_forced() -> None:
    found = read(bolted_askew(), "m.ifc")
    assert found.parts == ()
    (ledger,) = [d.message for d in found.diagnostics if d.code == "ifc-ledger"]
    assert "1 refused" in ledger, ledger
    assert "ifc-bolt-holes" not in [d.code for d in found.diagnostics]

    forced = read(bolted_askew(), "m.ifc", options=Options(force=True))
    assert len(forced.parts) == 1
    (said,) = {d.severity for d in forced.diagnostics if d.code == "ifc-bolt-skew"}
    assert said is Severity.WARNING


def test_the_ledger_counts_fasteners() -> None:
    found = read(with_a_nut(), "m.ifc")
    (said,) = [d.message for d in found.diagnostics if d.code == "ifc-bolts"]
    assert said == "found 3 fasteners: 1 made holes, 0 made none, 2 without a shank"
    (said,) = [d.message for d in found.diagnostics if d.code == "ifc-bolt-shank"]
    assert said.startswith("found 2 fasteners without a shank")


@pytest.mark.parametrize("code", ["ifc-length", "ifc-weight"])
def test_force_takes_the_geometry(code: str) -> None:
    assert read(CASES[code](), "m.ifc").parts == ()
    forced = read(CASES[code](), "m.ifc", options=Options(force=True))
    assert len(forced.parts) == 1
    assert not forced.refused
    assert [d.severity for d in forced.diagnostics if d.code == code] == [Severity.WARNING]


def test_a_selection_that_names_nothing_says_what_there_is() -> None:
    found = read(plain().data, "m.ifc", selection=Selection(marks=frozenset({"B9"})))
    (said,) = [d for d in found.diagnostics if d.code == "ifc-selection"]
    assert "B9" in said.message
    assert "B1" in said.message
    assert found.parts == ()


@pytest.mark.parametrize(("name", "found"), [("IfcBeam", 1), ("beam", 1), ("IfcWall", 0), ("x", 0)])
def test_a_class_without_members_says_what_there_is(name: str, found: int) -> None:
    reading = read(plain().data, "m.ifc", selection=Selection(classes=frozenset({name})))
    said = [d.message for d in reading.diagnostics if d.code == "ifc-selection"]
    assert len(reading.parts) == found
    expected = f"found no member with class {name}; expected one of the file's, such as IfcBeam"
    assert said == ([] if found else [expected])


@pytest.mark.parametrize(
    "data", [b"PK\x03\x04 nothing", plain().data[:-60], b"ISO-10303-21;\nHEADER;\n"]
)
def test_broken_files_are_refused(data: bytes) -> None:
    found = read(data, "m.ifc")
    assert [d.code for d in found.diagnostics] == ["ifc-syntax"]
    assert found.parts == ()


def test_a_zipped_model_is_read() -> None:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as archive:
        archive.writestr("model.ifc", plain().data)
    assert looks_like(held.getvalue())
    assert len(read(held.getvalue(), "model.ifczip").parts) == 1


def test_formats_are_told_apart() -> None:
    assert looks_like(plain().data)
    assert not looks_like(b"ST\n  1\n")
    assert not looks_like(b"0\nSECTION\n")
