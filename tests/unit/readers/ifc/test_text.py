"""The text of a model is looked over for what ifcopenshell would pass over."""

from typing import Any

import pytest

from beamcam.readers import read
from beamcam.readers.ifc.records import Entity, File, Missing, Typed
from beamcam.readers.ifc.text import Malformed, look_over, places, prepared, records
from tests.conftest import SAMPLES
from tests.unit.readers.ifc.models import Small

HEAD = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"


def looked(body: str) -> tuple[list[int], bool]:
    return look_over(prepared(f"{HEAD}{body}\nENDSEC;\nEND-ISO-10303-21;\n", "IFC4"))


def opened(body: str, schema: str = "IFC4") -> File:
    return File(f"{HEAD}{body}\nENDSEC;\nEND-ISO-10303-21;\n", schema)


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        (r"Tr\X2\00E4\X0\ger", "Träger"), (r"\X\E4", "ä"), (r"\S\d", "ä"), (r"a\\b", r"a\b"),
        (r"\X4\0001F600\X0\!", "\U0001f600!"), (r"\X2\D83DDE00\X0\!", "\U0001f600!"),
        (r"\PA\x", "x"), ("it''s", "it's"), (r"\X\27", "'"), (r"C:\Users\x", r"C:\Users\x"),
        (r"\X2\zz", r"\X2\zz"), (r"end\\", "end\\"), ("\\X\\0A.", "\n."), ("Träger", "Träger"),
        (r"\PE\\S\d", "ф"), (r"\X2\\X0\x", "x"),
    ],
)  # fmt: skip
def test_a_name_is_read_with_its_escapes_undone(raw: str, expected: str) -> None:
    m = Small()
    m.element(m.extruded(m.ipe300(), 1000.0), tag="MARK")
    data = m.data.decode().replace("'MARK'", f"'{raw}'").encode()
    (part,) = read(data, "m.ifc").parts
    assert part.mark == expected.strip()


def test_records_may_run_over_lines_and_share_them() -> None:
    body = "#1=IFCX('a;\n''b'\n,1.);#2 = IFCY ( #1 ) ;\n/* #3=IFCZ(); */#04=IFCZ(#01);"
    found = {r.number: (r.kind, r.inner) for r in records(prepared(f"{HEAD}{body}ENDSEC;", "IFC4"))}
    assert found == {
        1: ("IFCX", "'a;\n''b'\n,1."), 2: ("IFCY", "#1"), 4: ("IFCZ", "#01")
    }  # fmt: skip
    assert looked(body)[0] == [1, 2, 4]
    assert not looked(body)[1]  # for the zeros, which do no harm


def test_two_sections_are_one_file() -> None:
    for data in ("DATA", "DATA ", "DATA('b',('IFC4'))"):
        assert looked(f"#1=IFCX(1);\nENDSEC;\n{data};\n#2=IFCX(2);")[0] == [1, 2]


def test_a_section_without_an_end_is_refused() -> None:
    with pytest.raises(Malformed, match="without an end") as fault:
        look_over(HEAD + "#1=IFCX(1);\n")
    assert fault.value.line == 5


@pytest.mark.parametrize(
    ("body", "found", "line"),
    [
        ("#1=IFCX(1);\nrubbish\n#2=IFCX(2);", "rubbish", 7),
        ("#1=IFCX('a','b\nc');\n#2=IFCX('d');\nrubbish;", "rubbish", 9),
        ("#1=IFCX(1);\n#1=IFCX(2);", "record #1 twice", 7),
        ("#1=IFCX(1);\n#01=IFCX(2);", "record #1 twice", 7),
        ("#1=IFCX(1);\n#2=();", "#2=();", 7),
        ("#1=IFCX(1);\n\n #2=IFC,X(1);", "#2=IFC,X(1);", 8),
        ("#1=IFCX(1);\n#2=IFCX;", "#2=IFCX;", 7),
        ("#1=IFCX(1);\n#2=IFCX(1;", "#2=IFCX(1;", 7),
        ("#1=IFCX(1);\n#=IFCX(1);", "#=IFCX(1);", 7),
        ("#1=IFCX(1);\n#1234567890123456789=IFCX(1);", "#1234567890123456789", 7),
        ("ENDSEC;\n#1=IFCX(1);\nDATA;", "#1=IFCX(1);", 7),
    ],
)
def test_what_is_no_record_is_named(body: str, found: str, line: int) -> None:
    with pytest.raises(Malformed) as fault:
        looked(body)
    assert found in str(fault.value)
    assert fault.value.line == line


@pytest.mark.parametrize(
    "values",
    [
        "#1,#2", "(#1,$)", "(1.,,2.)", "(1.,)", ",", "(())", "(1.\n2.)", "((1.,*))", "1E9",
        "1.E300", "(#1 #1)", "#1=#1", "(((((1.)))))", "#1234567890", "IFCLABEL", "nan", "1.5.2",
        "#a", "#-3", "#1 #1", "T(1.)U", "1_0", "0x1", "9" * 5000, "(" * 100_000,
    ],
)  # fmt: skip
def test_what_ifcopenshell_passes_over_is_doubtful(values: str) -> None:
    assert not looked(f"#1=IFCX({values});")[1]


@pytest.mark.parametrize(
    "values",
    [
        "#1,$,*,.T.,'a,(','it''s'", "(#1,#1)", "((1.,2.),( 3. ,\n4.))", "", " ", "1.E9,-1.E-05",
        "IFCLABEL('a')", "(#1,IFCPARAMETERVALUE(0.))", "IFCX ((1.,2.))", '"0FF"', "()", "IFCX($)",
        "(IFCLINEINDEX((1,2)),IFCARCINDEX((2,3,4)))",
    ],
)  # fmt: skip
def test_what_is_written_well_is_not(values: str) -> None:
    assert looked(f"#1=IFCX({values});")[1]


# --- doubts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("inner", "expected"),
    [
        ("", []), (" $ ", ["$"]),
        (".AREA.,'a,(',( #05 , $ ),-9.E-1", [".AREA.", "'", "(#5,$)", "n"]),
        ("'it''s','',7", ["'", "'", "n"]), ("IfcLabel('a'),*", ["IFCLABEL(')", "$"]),
        ("((1.,2.),(3.,)),\"0ff\"", ["((n,n),(n,))", '"0FF"']), ("1E9,#-3", ["1E9", "#n"]),
    ],
)  # fmt: skip
def test_the_places_of_a_record_without_its_numbers_and_strings(
    inner: str, expected: list[str]
) -> None:
    assert places(inner) == expected


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ("#9,.NONSENSE.,$,#1", 1), ("#9,.AREA.,IFCNONSENSE(5.),#1", 2), ("#9,.X.,'a',(#1,#9)", 1),
        ("#9,.AREA.,(1.,'a',3.),#1", 2), ("#9,.AREA.,('a',#1),#1", 2), ("#9,.T.,(.T.,.F.),#1", 2),
    ],
)  # fmt: skip
def test_a_value_that_is_read_otherwise_fails_when_it_is_looked_at(values: str, place: int) -> None:
    """And no other value of its record does."""
    one = opened(f"#1=IFCPROFILEDEF({values.split(',')[1]},$);\n#2=IFCRELNESTS('a',{values},(#1));")
    values_of_it = one.entity(2).values
    with pytest.raises(Malformed, match=f"value {place + 2} of #2=IFCRELNESTS"):
        values_of_it[place + 1]
    with pytest.raises(Malformed):
        _, *_ = values_of_it
    with pytest.raises(Malformed):
        values_of_it[place:]
    assert values_of_it[0] == "a"
    assert isinstance(values_of_it[1], Missing)
    assert values_of_it[-1] == (one.entity(1),)


def test_a_record_that_ifcopenshell_has_not_fails_when_it_is_looked_at() -> None:
    rows = "#1=IFCBEAM('a',$,1.5.2,$,$,$,$,$);\n#2=IFCX(1.);\n#3=IFCBEAM('b',$,$,$,$,$,$,'T',$);"
    file = opened(f"{rows}\n#4=IFCRELNESTS('c',$,$,$,#1,(#2,#3,#5));")
    beams = file.by_type("IfcBeam")
    assert [(one.name, one.guid) for one in beams] == [("#1", "a"), ("#3", "b")]
    assert file.by_type("IfcElement") == beams
    with pytest.raises(
        Malformed, match=r"#1=IFCBEAM\('a',\$,1.5.2,\$,\$,\$,\$,\$\), not as the schema has it"
    ):
        _ = beams[0].Tag
    whole, parts = file.entity(4).values[4:]
    assert (whole, parts[1], beams[1].Tag) == (beams[0], beams[1], "T")
    assert (parts[0].is_a(), parts[0].is_a("IfcRoot")) == ("IFCX", False)
    with pytest.raises(LookupError, match="#5, which is not in the file"):
        _ = parts[2].values


def test_a_model_is_read_whatever_its_header_says() -> None:
    body = "#1=IFCPROPERTYSINGLEVALUE('a',$,IFCLABEL($),$);"
    for head in ("HEADER;\n", "HEADER;\nFILE_NAME('C:\\x,'');\nENDSEC;\n", ""):
        file = File(f"ISO-10303-21;\n{head}DATA;\n{body}\nENDSEC;\n", "IFC2X3")
        assert file.entity(1).values == ("a", None, Typed("IFCLABEL", None), None)


@pytest.mark.parametrize("path", sorted((SAMPLES / "ifc").glob("*.ifc")), ids=lambda p: p.stem)
def test_a_fault_elsewhere_changes_no_value(path: Any) -> None:
    text = path.read_text("utf-8")
    schema = "IFC2X3" if "IFC2X3" in text[:2000] else "IFC4"
    fault = text.replace("\nDATA;", "\nDATA;\n#999999=IFCPOLYLINE((#999998));")
    sound, doubtful = File(text, schema), File(fault, schema)
    assert not sound._written
    assert doubtful._written

    def plainly(v: Any) -> Any:
        if isinstance(v, Entity):
            return v.number, v.type.name
        return tuple(map(plainly, v)) if isinstance(v, tuple) else v

    for name in look_over(prepared(text, schema))[0]:
        one, other = sound.entity(name), doubtful.entity(name)
        if isinstance(one, Entity):
            assert plainly(one.values) == plainly(other.values)
        assert plainly(one) == plainly(other)


def test_a_closed_file_goes_at_once_with_entities_that_lead_back_to_themselves() -> None:
    body = "#1=IFCLOCALPLACEMENT(#2,$);\n#2=IFCLOCALPLACEMENT(#1,$);"
    file = File(f"{HEAD}{body}\nENDSEC;\nEND-ISO-10303-21;\n", "IFC4")
    one = file.entity(1)
    assert one.PlacementRelTo.PlacementRelTo is one
    file.close()
    assert one.values == ()
