"""Every code of the reader of models is met by an input that deserves it."""

import io
import zipfile
from collections.abc import Callable

import pytest

from beamcam.errors import Rule, Severity
from beamcam.readers.ifc import Options, Selection, looks_like, read, rules
from tests.property.ifc_cuts import SIZES, Bar, Box, model_of
from tests.unit.readers.ifc.models import ORIGIN, Small
from tests.unit.readers.ifc.test_wholes import with_a_projection

RULES = [value for value in vars(rules).values() if isinstance(value, Rule)]


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


def slotted(code: str = "RO", low: float = -9.0) -> bytes:
    """A round tube or a solid bar with a slot for a gusset at its end."""
    box = Box((-9.0, low, 20.0), (150.0, 180.0, 30.0))
    return model_of(Bar(code, 900.0, SIZES[code]), [box])


def special_with_a_hole() -> bytes:
    m = Small()
    part = m.polygon((0, 0), (90, 0), (60, 40), (0, 40))
    m.element(m.minus(m.extruded(part, 900.0), m.hole((500, -20, 20), (0, 1, 0), 18.0, 60.0)))
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


def two_grades(material: str = "S355JR", grade: str = "S460") -> bytes:
    m = Small()
    e = m.element(m.extruded(m.ipe300(), 2000.0))
    m.material(e, material)
    m.properties(e, "Pset_MemberCommon", Grade=f"IFCLABEL('{grade}')")
    return m.data


def stated(**quantities: str) -> bytes:
    """An IPE 300 of 2 m, 84.5 kg, with what Tekla says of it."""
    m = Small()
    m.properties(m.element(m.extruded(m.ipe300(), 2000.0)), "Tekla Quantity", **quantities)
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


def shaved() -> bytes:
    """A tenth of a millimetre off a flange, all along it."""
    m = Small()
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.half((0, 0, 149.9), (0, 0, 1))))
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


def planed() -> bytes:
    """A flange that is planed thinner."""
    m = Small()
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.half((0, 0, 145), (0, 0, 1))))
    return m.data


def sloped() -> bytes:
    m = Small()
    profile = m.add(f"IFCUSHAPEPROFILEDEF(.AREA.,$,{m.flat},200.,75.,11.5,8.5,11.5,6.,4.57)")
    m.element(m.extruded(profile, 2000.0))
    return m.data


def bow() -> bytes:
    """A section whose outline crosses itself."""
    m = Small()
    profile = m.polygon((0, 0), (100, 0), (100, 10), (20, 60), (60, 60), (0, 10))
    m.element(m.extruded(profile, 2000.0))
    return m.data


def beside_the_web() -> bytes:
    """The upper flange cut off on one side of the web, the fillet below it left."""
    m = Small()
    at = m.step.axes((0, 3.55, 150.0), (0, 1, 0), (1, 0, 0))
    block = m.extruded(m.box(160, 21.4), 75.0, at)
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), block))
    return m.data


def grooved() -> bytes:
    """A groove along each fillet, as deep as the fillet is."""
    m = Small()
    body = m.extruded(m.ipe300(), 2000.0)
    for y, z in ((7.5, 135.0), (7.5, -135.0), (-7.5, 135.0), (-7.5, -135.0)):
        place = m.step.axes((0, y, z), (1, 0, 0), (0, 1, 0))
        body = m.minus(body, m.extruded(m.box(8, 8), 2000.0, place))
    m.element(body)
    return m.data


def lipped(lower: float, upper: float) -> bytes:
    """A channel of 200 x 75 x 2.5 with lips of these lengths."""
    m = Small()
    outline = m.polygon(
        (0, 0), (75, 0), (75, lower), (72.5, lower), (72.5, 2.5), (2.5, 2.5), (2.5, 197.5),
        (72.5, 197.5), (72.5, 200 - upper), (75, 200 - upper), (75, 200), (0, 200),
    )  # fmt: skip
    m.element(m.extruded(outline, 2000.0))
    return m.data


def with_lips() -> bytes:
    return lipped(20.0, 25.0)


def test_lips_of_one_length_are_the_parts_own() -> None:
    found = read(lipped(20.0, 20.0), "m.ifc")
    assert [part.profile.lip for part in found.parts] == [20.0]
    assert "ifc-lips" not in {d.code for d in found.diagnostics}
    (other,) = read(with_lips(), "m.ifc").parts
    assert other.profile.lip is None
    m = Small()
    profile = m.add(f"IFCCSHAPEPROFILEDEF(.AREA.,$,{m.flat},200.,75.,2.5,20.,4.,$)")
    m.element(m.extruded(profile, 2000.0))
    assert [part.profile.lip for part in read(m.data, "m.ifc").parts] == [20.0]


def saddled() -> bytes:
    """A square tube that meets a round one."""
    m = Small()
    profile = m.add(f"IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},100.,200.,8.,$,$)")
    round_ = m.extruded(m.circle(120), 400.0, m.step.axes((0, 0, -200), (0, 0, 1), (1, 0, 0)))
    m.element(m.minus(m.extruded(profile, 2000.0), round_))
    return m.data


def bent() -> bytes:
    """Two lengths of a flat bar that meet at 20 degrees."""
    m = Small()
    turned = m.step.axes((990, 0, 0), (0.9396926, 0.3420201, 0), (-0.3420201, 0.9396926, 0))
    pieces = m.extruded(m.box(20, 90), 1000.0), m.extruded(m.box(20, 90), 900.0, turned)
    m.element(m.add(f"IFCBOOLEANRESULT(.UNION.,{pieces[0]},{pieces[1]})"))
    return m.data


def with_a_slab() -> bytes:
    m = plain()
    m.element(m.extruded(m.box(2000, 200), 3000.0), "IFCSLAB")
    return m.data


def with_a_misspelt_class() -> bytes:
    """The beam that is written right is read, of the other there is a word."""
    m = plain()
    m.add("IFCBAEM('0aaaaaaaaaaaaaaaaaaaaa',$,'B2',$,$,$,$,$)")
    return m.data


def of_another_volume() -> bytes:
    m = Small()
    e = m.element(m.extruded(m.ipe300(), 2000.0))
    quantity = m.add("IFCQUANTITYVOLUME('NetVolume',$,$,0.010562,$)")
    found = m.add(
        f"IFCELEMENTQUANTITY('{m.step.guid()}',{m.step.owner},'Qto_BeamBaseQuantities',$,$,"
        f"({quantity}))"
    )
    m.add(f"IFCRELDEFINESBYPROPERTIES('{m.step.guid()}',{m.step.owner},$,$,({e}),{found})")
    return m.data


def with_a_listed_cope() -> bytes:
    m = Small()
    e = m.element(m.extruded(m.ipe300(), 2000.0))
    m.properties(e, "PSet_Cutout", Length="IFCREAL(100.)")
    return m.data


def bolted_through_a_slot() -> bytes:
    """A shim with an open slot: the bolt needs no hole."""
    m = Small()
    shim = m.extruded(m.box(200, 80), 4.0, m.step.axes(ORIGIN, (0, 0, 1), (1, 0, 0)))
    slot = m.extruded(m.box(22, 60), 20.0, m.step.axes((60, 40, -8), (0, 0, 1), (1, 0, 0)))
    m.element(m.minus(shim, slot), "IFCPLATE")
    m.bolt((60, 25, -20), (0, 0, 1), 20.0, 60.0)
    return m.data


#: What only the geometry kernel tells.
CHECKED: dict[str, Callable[[], bytes]] = {
    "ifc-unexplained": planed,
    "ifc-section-area": sloped,
    "ifc-outline": bow,
    "ifc-root-fillet": beside_the_web,
    "ifc-root-cut": grooved,
    "ifc-leaning-edge": saddled,
    "ifc-volume": shaved,
}
CASES: dict[str, Callable[[], bytes]] = {
    **CHECKED,
    "ifc-kinked": bent,
    "ifc-lips": with_lips,
    "ifc-other-classes": with_a_slab,
    "ifc-unknown-class": with_a_misspelt_class,
    "ifc-weight-near": lambda: stated(NetWeight="IFCMASSMEASURE(88.4)"),
    "ifc-net-volume": of_another_volume,
    "ifc-cutout": with_a_listed_cope,
    "ifc-bolt-air": bolted_through_a_slot,
    "ifc-syntax": syntax,
    "ifc-schema": schema,
    "ifc-no-members": no_members,
    "ifc-left-out": left_out,
    "ifc-curved": curved,
    "ifc-tapered": tapered,
    "ifc-geometry": askew,
    "ifc-section": no_section,
    "ifc-odd-cut": lambda: slotted(low=140.0),
    "ifc-solid-cut": lambda: slotted("RU"),
    "ifc-special-cut": special_with_a_hole,
    "ifc-square-cut": slotted,
    "ifc-profile-name": wrong_name,
    "ifc-grade": two_grades,
    "ifc-length": lambda: stated(Length="IFCLENGTHMEASURE(2100.)"),
    "ifc-weight": lambda: stated(NetWeight="IFCMASSMEASURE(42.)"),
    "ifc-kernel-fitted": elliptic,
    "ifc-pieces": in_two,
    "ifc-bolt-holes": bolted,
    "ifc-bolt-skew": bolted_askew,
    "ifc-bolt-shank": with_a_nut,
    "ifc-bolts": bolted,
    "ifc-ledger": lambda: plain().data,
    "ifc-projection": with_a_projection,
}
ELSEWHERE = {
    "ifc-selection", "ifc-kernel", "ifc-kernel-log", "ifc-kernel-died", "ifc-kernel-denied",
    "ifc-volume-off",
}  # fmt: skip


def test_every_code_has_a_case() -> None:
    assert {r.code for r in RULES} == set(CASES) | ELSEWHERE


@pytest.mark.parametrize("code", CASES)
def test_code_is_said(code: str) -> None:
    found = read(CASES[code](), "model.ifc", options=Options(kernel=code in CHECKED))
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


@pytest.mark.parametrize(
    ("material", "grade", "apart"),
    [("S355JR", "S355", False), ("STEEL/S355JR", "S460", True), ("S355JR", "S355J2", True),
     ("Steel", "S460", False), ("S355JR", "A36", False), ("A992", "A36", True)],
)  # fmt: skip
def test_two_steels_are_told(material: str, grade: str, apart: bool) -> None:
    found = read(two_grades(material, grade), "m.ifc")
    assert ("ifc-grade" in [d.code for d in found.diagnostics]) is apart
    assert found.parts[0].grade == grade


@pytest.mark.parametrize("usage", [False, True])
@pytest.mark.parametrize(("name", "wrong"), [("IPE500", True), ("IPE300", False), ("mine", False)])
def test_the_name_of_a_profile_set_is_compared(name: str, wrong: bool, usage: bool) -> None:
    m = Small()
    profile = m.ipe300()
    e = m.element(m.extruded(profile, 2000.0))
    steel = m.add("IFCMATERIAL('S355JR',$,$)")
    row = m.add(f"IFCMATERIALPROFILE($,$,{steel},{profile},$,$)")
    of = m.add(f"IFCMATERIALPROFILESET('{name}',$,({row}),$)")
    if usage:
        of = m.add(f"IFCMATERIALPROFILESETUSAGE({of},5,$)")
    m.add(f"IFCRELASSOCIATESMATERIAL('{m.step.guid()}',$,$,$,({e}),{of})")
    found = read(m.data, "m.ifc")
    said = [d.message for d in found.diagnostics if d.code == "ifc-profile-name"]
    assert [name in text for text in said] == [True] * wrong
    assert found.parts[0].grade == "S355JR"
