"""STEP files: records and their values, as ifcopenshell has them too."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc.records import Entity, File
from beamcam.readers.ifc.step import Malformed, Tokens, Typed, records, text_of, tidy
from tests.conftest import SAMPLES

HEAD = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"
TAIL = "\nENDSEC;\nEND-ISO-10303-21;\n"


def inner(body: str) -> dict[str, str]:
    return records(tidy(HEAD + body + TAIL)).inner


def value(text: str) -> Any:
    (only,) = Tokens({}, lambda name: name).values(text)
    return only


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1.5", 1.5), ("-1.E-05", -1e-5), ("7", 7), ("$", None), ("*", None),
        (".T.", True), (".F.", False), (".U.", "UNKNOWN"), (".AREA.", "AREA"),
        ("#12", "#12"), ("'O''Brien'", "O'Brien"), ("'a,(b);c'", "a,(b);c"), ("''", ""),
        ("(1.,2.)", (1.0, 2.0)), ("()", ()), ("((1,2),(3,4))", ((1, 2), (3, 4))),
        ("('a',#3)", ("a", "#3")), (" $ ", None), ('"0FA"', "0FA"),
        ("IFCLABEL('x')", Typed("IFCLABEL", "x")),
        ("IFCLENGTHMEASURE(25.4)", Typed("IFCLENGTHMEASURE", 25.4)),
        ("(IFCARCINDEX((1,2,3)))", (Typed("IFCARCINDEX", (1, 2, 3)),)),
    ],
)  # fmt: skip
def test_a_value_is_what_it_says(text: str, expected: object) -> None:
    assert value(text) == expected
    assert type(value(text)) is type(expected)


@pytest.mark.parametrize("text", ["nan", "inf", "1_0.5", "abc", "", "#x", "(1.", "1.)", "'a"])
def test_what_is_no_value_is_refused(text: str) -> None:
    with pytest.raises(Malformed):
        Tokens({}, lambda name: name).values(f"{text},$")


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        (r"Tr\X2\00E4\X0\ger", "Träger"), (r"\X\E4", "ä"), (r"\S\d", "ä"), (r"a\\b", "a\\b"),
        (r"\X4\0001F600\X0\!", "\U0001f600!"), (r"\PA\x", "x"), ("it''s", "it's"),
    ],
)  # fmt: skip
def test_escapes_are_undone(raw: str, expected: str) -> None:
    assert text_of(raw) == expected


def test_records_may_run_over_lines_and_share_them() -> None:
    body = "#1=IFCX('a;\n''b'\n,1.);#2 = IFCY ( #1 ) ;\n/* #3=IFCZ(); */#04=IFCZ(#01);"
    assert inner(body) == {"#1": "'a;\n''b'\n,1.)", "#2": " #1 ) ", "#4": "#1)"}


def test_two_sections_are_one_file() -> None:
    assert inner("#1=IFCX(1);\nENDSEC;\nDATA;\n#2=IFCX(2);") == {"#1": "1)", "#2": "2)"}


@pytest.mark.parametrize(
    ("body", "found", "line"),
    [
        ("#1=IFCX(1);\nrubbish\n#2=IFCX(2);", "rubbish", 7),
        ("#1=IFCX(1);\n#2=IFCX(2)\n#3=IFCX('", "#3=IFCX('", None),
        ("#1=IFCX(1);\n#1=IFCX(2);", "record #1 twice", None),
        ("#1=IFCX(1);\n#2=();", "#2=();", 7),
    ],
)
def test_what_is_no_record_is_named(body: str, found: str, line: int | None) -> None:
    with pytest.raises(Malformed) as fault:
        inner(body)
    assert found in str(fault.value)
    if line is not None:
        assert fault.value.line == line


@given(
    st.lists(
        st.one_of(
            st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="\\")),
            st.floats(-1e9, 1e9).map(lambda v: round(v, 6)),
            st.integers(-1000, 1000),
            st.none(),
            st.booleans(),
        ),
        min_size=1,
    )
)
def test_what_is_written_is_read(values: list[Any]) -> None:
    def written(v: Any) -> str:
        if v is None or isinstance(v, bool):
            return {None: "$", True: ".T.", False: ".F."}[v]
        if isinstance(v, str):
            return "'" + v.replace("'", "''") + "'"
        return repr(v).replace("e", "E") if "." in repr(v) or isinstance(v, int) else f"{v:.6f}"

    text = "#7=IFCX(" + ",".join(map(written, values)) + ");"
    assert Tokens({}, lambda n: n).values(inner(text)["#7"][:-1]) == tuple(values)


@pytest.mark.parametrize("path", sorted(SAMPLES.glob("ifc/*.ifc")), ids=lambda p: p.name)
def test_every_entity_has_the_values_that_ifcopenshell_gives(path: Any) -> None:
    ifcopenshell = pytest.importorskip("ifcopenshell")
    theirs = ifcopenshell.open(str(path))
    text = path.read_text("utf-8")
    ours = File(text, theirs.schema)

    def plain(v: Any) -> Any:
        if isinstance(v, tuple):
            return tuple(map(plain, v))
        if isinstance(v, Entity):
            return v.id()
        if isinstance(v, Typed):
            return (v.kind, v.value)
        if hasattr(v, "is_a"):
            if v.is_a() in ("IfcCartesianPoint", "IfcDirection"):
                return tuple(v[0])
            if v.is_a() in ("IfcAxis2Placement2D", "IfcAxis2Placement3D"):
                return tuple(plain(x) for x in v)
            return v.id() or (v.is_a().upper(), v[0])
        return v

    count = 0
    for entity in theirs:
        mine = ours.tokens[f"#{entity.id()}"]
        if isinstance(mine, Entity):
            expected = [None if x == () else plain(x) for x in entity]
            got = [None if x == () else plain(x) for x in mine.values]
            assert got == expected, entity
            if len(mine.row.places):
                assert mine.is_a() == entity.is_a()
        else:
            assert mine == plain(entity)
        count += 1
    assert count > 20


@pytest.mark.parametrize(
    ("values", "label"),
    [
        ("'g',#1,'Tekla Common',$,(#1))", "Tekla Common"), ("'g',#1,$,'x',(#1))", None),
        ("'g',#1,'it''s',$,(#1))", "it's"), (r"'g',$,'Tr\X\E4ger',$,())", "Träger"),
        ("$,#1,'Tekla',$,(#1))", "Tekla"), ("'g',#1,'','',())", ""),
    ],
)  # fmt: skip
def test_a_label_is_the_third_value(values: str, label: str | None) -> None:
    text = f"{HEAD}#1=IFCOWNERHISTORY($);\n#2=IFCPROPERTYSET({values};{TAIL}"
    entity = File(text, "IFC4").entity("#2")
    assert entity.label == label
    assert entity.label == entity.values[2]


_TEXTS = st.sampled_from(["$", "''", "'Phase'", "'a, (b) #1'", r"'\X2\00E9\X0\'", "'it''s'"])
_BARE = st.sampled_from(["$", "*", "#7", "12.5", "-3", ".T.", ".MILLI."])


@given(_TEXTS, _TEXTS, st.sampled_from(["IFCLABEL", "IfcLengthMeasure"]), _TEXTS | _BARE, _BARE)
def test_a_property_is_read_as_any_record(
    name: str, about: str, kind: str, value: str, unit: str
) -> None:
    inner = f"{name},{about},{kind}({value}),{unit}"
    tokens = Tokens({}, lambda at: ("record", at))
    assert tokens.values(inner) == tokens._nested(inner)


@given(_TEXTS, _BARE, _TEXTS, st.lists(st.integers(1, 99), min_size=1, max_size=4))
def test_a_relation_is_read_as_any_record(
    guid: str, owner: str, name: str, many: list[int]
) -> None:
    inner = f"{guid},{owner},{name},$,({','.join(f'#{i}' for i in many)}),#200"
    tokens = Tokens({}, lambda at: ("record", at))
    assert tokens.values(inner) == tokens._nested(inner)
