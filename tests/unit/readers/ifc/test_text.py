"""The text of a model is looked over for what ifcopenshell would pass over."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers import read
from beamcam.readers.ifc.records import Entity, File
from beamcam.readers.ifc.text import Malformed, Typed, look_over, plain, records, values_of
from tests.conftest import SAMPLES
from tests.unit.readers.ifc.models import Small

HEAD = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"


def looked(body: str) -> tuple[list[str], bool]:
    return look_over(plain(f"{HEAD}{body}\nENDSEC;\nEND-ISO-10303-21;\n"))


def value(text: str) -> Any:
    (found, last) = values_of(f"{text},$", lambda number: f"#{number}")
    assert last is None
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1.", 1.0), ("-1.E-05", -1e-5), ("7", 7), (".T.", True), (".F.", False),
        (".U.", "UNKNOWN"), (".AREA.", "AREA"), ("$", None), ("*", None), ("#12", "#12"),
        ("'it''s, (b'", "it's, (b"), ("''", ""), ("()", ()), ("(1.,2.)", (1.0, 2.0)),
        ("((1.,2.),(3.,4.))", ((1.0, 2.0), (3.0, 4.0))), ("( 1. , #2 )", (1.0, "#2")),
        ("IFCLABEL('a')", Typed("IFCLABEL", "a")), ("IfcText($)", Typed("IFCTEXT", None)),
        ("(#5,IFCPARAMETERVALUE(0.5))", ("#5", Typed("IFCPARAMETERVALUE", 0.5))),
        ('"0FF"', "0FF"),
    ],
)  # fmt: skip
def test_a_value_is_what_it_says(text: str, expected: object) -> None:
    assert value(text) == expected
    assert type(value(text)) is type(expected)


@pytest.mark.parametrize(
    "text",
    [
        "", "(1.,,2.)", "(1.,)", "1. 2.", "IFCLABEL", "T 'a'", "(1.)2.", "T(abc)", "T(1.)U",
        "'a'b'c'", "1.5.2", "1_0", "nan", "1E9", "0x1", "(1.", "1.)", "#a", "9" * 5000,
        "(" * 100_000,
    ],
)  # fmt: skip
def test_what_is_no_value_is_refused(text: str) -> None:
    with pytest.raises(Malformed):
        value(text)


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        (r"Tr\X2\00E4\X0\ger", "Träger"), (r"\X\E4", "ä"), (r"\S\d", "ä"), (r"a\\b", r"a\b"),
        (r"\X4\0001F600\X0\!", "\U0001f600!"), (r"\X2\D83DDE00\X0\!", "\U0001f600!"),
        (r"\PA\x", "x"), ("it''s", "it's"), (r"\X\27", "'"), (r"C:\Users\x", r"C:\Users\x"),
        (r"\X2\zz", r"\X2\zz"), (r"end\\", "end\\"), ("\\X\\0A.", "\n."), ("Träger", "Träger"),
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
    found = {r.number: (r.kind, r.inner) for r in records(plain(body))}
    assert found == {
        1: ("IFCX", "'a;\n''b'\n,1."), 2: ("IFCY", " #1 "), 4: ("IFCZ", "#01")
    }  # fmt: skip
    assert list(map(int, looked(body)[0])) == [1, 2, 4]
    assert not looked(body)[1]


def test_two_sections_are_one_file() -> None:
    for data in ("DATA", "DATA ", "DATA('b',('IFC4'))"):
        assert looked(f"#1=IFCX(1);\nENDSEC;\n{data};\n#2=IFCX(2);")[0] == ["1", "2"]


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
        "#1,#2", "(#1,$)", "(1.,,2.)", "(1.,)", ",", "()", "(())", "(1.\n2.)", "((1.,*))", "1E9",
        "(#1 #1)", "IFCLABEL($)", "#1=#1", "((((1.))))", "#1234567890",
    ],
)  # fmt: skip
def test_what_ifcopenshell_passes_over_is_doubtful(values: str) -> None:
    assert looked(f"#1=IFCX({values});")[1]


@pytest.mark.parametrize(
    "values",
    [
        "#1,$,*,.T.,'a,(','it''s'", "(#1,#1)", "((1.,2.),( 3. ,\n4.))", "", " ", "1.E9,-1.E-05",
        "IFCLABEL('a')", "(#1,IFCPARAMETERVALUE(0.))", "IFCX ((1.,2.))", '"0FF"',
    ],
)  # fmt: skip
def test_what_is_written_well_is_not(values: str) -> None:
    assert not looked(f"#1=IFCX({values});")[1]


_SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(-(10**9), 10**9), st.text(st.characters(codec="utf-8")),
    st.floats(allow_nan=False, allow_infinity=False),
)  # fmt: skip


@given(st.lists(st.recursive(_SCALARS, lambda each: st.lists(each, max_size=3).map(tuple))))
def test_what_is_written_is_read(values: list[Any]) -> None:
    def written(v: Any) -> str:
        if v is None:
            return "$"
        if isinstance(v, bool):
            return ".T." if v else ".F."
        if isinstance(v, tuple):
            return f"({','.join(map(written, v))})"
        if isinstance(v, str):
            return "'" + v.replace("\\", r"\\").replace("'", "''") + "'"
        text = repr(v)
        return text if not isinstance(v, float) or "." in text else text.replace("e", ".e")

    assert values_of(",".join(map(written, values)), lambda number: number) == tuple(values)


@pytest.mark.parametrize("path", sorted((SAMPLES / "ifc").glob("*.ifc")), ids=lambda p: p.stem)
def test_both_readings_of_a_record_are_equal(path: Any) -> None:
    """By ifcopenshell, and by the text, as of a file that has a fault elsewhere."""
    text = path.read_text("utf-8")
    schema = "IFC2X3" if "IFC2X3" in text[:2000] else "IFC4"
    fault = text.replace("\nDATA;", "\nDATA;\n#999999=IFCPOLYLINE((#999998));")
    sound, doubtful = File(text, schema), File(fault, schema)
    assert sound._written is None
    assert doubtful._written is not None

    def plainly(v: Any) -> Any:
        if isinstance(v, Entity):
            return v.number, v.type.name
        return tuple(map(plainly, v)) if isinstance(v, tuple) else v

    for name in look_over(plain(text))[0]:
        one, other = sound.entity(int(name)), doubtful.entity(int(name))
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
