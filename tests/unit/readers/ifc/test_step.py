"""STEP files: records and their values, as ifcopenshell has them too."""

import re
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc.records import Entity, File
from beamcam.readers.ifc.step import MISSING, NONE_GIVEN, Malformed, Typed, records
from beamcam.readers.ifc.values import Tokens, text_of
from tests.conftest import SAMPLES

HEAD = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"
TAIL = "\nENDSEC;\nEND-ISO-10303-21;\n"


def inner(body: str) -> dict[str, str]:
    found = records(HEAD + body + TAIL)
    return {found.name(i): found.inner(i) for i in range(len(found))}


def value(text: str) -> Any:
    (only,) = Tokens(lambda name, number: name).values(text)
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


@pytest.mark.parametrize(
    "text",
    [
        "nan",
        "inf",
        "1_0.5",
        "abc",
        "",
        "#x",
        "(1.",
        "1.)",
        "'a",
        "'a,b' 'c'",
        "'a,b',",
        "(1.,)",
        "1. 2.",
        "IFCLABEL",
        "T 'a'",
        "(1.)2.",
        "T(abc)",
        "T(1.)U",
        "((1.),,2.)",
        "'a'b'c'",
        "'a,'b",
    ],
)
def test_what_is_no_value_is_refused(text: str) -> None:
    with pytest.raises(Malformed):
        Tokens(lambda name, number: name).values(f"{text},$")
    with pytest.raises(Malformed):
        Tokens(lambda name, number: name).values(f"'a, b',{text}")


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
    assert inner(body) == {"#1": "'a;\n''b'\n,1.", "#2": " #1 ", "#4": "#1"}


def test_two_sections_are_one_file() -> None:
    for data in ("DATA", "DATA ", "DATA('b',('IFC4'))"):
        text = f"#1=IFCX(1);\nENDSEC;\n{data};\n#2=IFCX(2);"
        assert inner(text) == {"#1": "1", "#2": "2"}


def test_a_section_without_an_end_is_refused() -> None:
    with pytest.raises(Malformed, match="without an end") as fault:
        records(HEAD + "#1=IFCX(1);\n")
    assert fault.value.line == 5


@pytest.mark.parametrize(
    ("body", "found", "line"),
    [
        ("#1=IFCX(1);\nrubbish\n#2=IFCX(2);", "rubbish", 7),
        ("#1=IFCX(1);\n#2=IFCX(2)\n#3=IFCX('", "#3=IFCX('", None),
        ("#1=IFCX(1);\n#1=IFCX(2);", "record #1 twice", 7),
        ("#1=IFCX(1);\n#2=();", "#2=();", 7),
        ("#1=IFCX(1);\n\n #2=IFC,X(1);", "#2=IFC,X(1);", 8),
        ("#1=IFCX(1);\n#2=IFCX;", "#2=IFCX;", 7),
        ("#1=IFCX(1);\n#2=IFCX(1;", "#2=IFCX(1;", 7),
        ("#1=IFCX(1);\n#=IFCX(1);", "#=IFCX(1);", 7),
        ("#1=IFCX(1);\n#1234567890123456789=IFCX(1);", "#1234567890123456789", 7),
        ("ENDSEC;\n#1=IFCX(1);\nDATA;", "#1=IFCX(1);", 7),
    ],
)
def test_what_is_no_record_is_named(body: str, found: str, line: int | None) -> None:
    with pytest.raises(Malformed) as fault:
        inner(body)
    assert found in str(fault.value)
    if line is not None:
        assert fault.value.line == line


# What a record is, as one pattern; read so it costs three times as much.
_RECORD = re.compile(r"#(\d++)\s*+=\s*+(\w++)\s*+\(((?:[^';]++|'[^']*+')*+);")


def by_pattern(text: str) -> list[tuple[str, str, str]]:
    """Name, class and what is between the brackets."""
    return [(n, k, i.rstrip().removesuffix(")")) for n, k, i in _RECORD.findall(text)]


_CLASSES = st.sampled_from([
    "IFCBEAM", "IfcBeam", "IFCAXIS2PLACEMENT3D", "IFCAXIS2PLACEMENT2D", "X", "IFCBEAN",
    "IFCRELASSOCIATESMATERIAL", "IFCRELASSOCIXTESMATERIAL", "IFCRELXSSOCIATESMATERIAL",
])  # fmt: skip
_PIECES = st.sampled_from(
    ["1.", "#2", "$", "'a;b'", "'it''s'", "';\n#9=IFCX();'", "'Ж'", "'\U0001f600;'", "''", "\r\n"]
)
_GAPS = st.sampled_from(["", " ", "\n", "\r\n", "\n\n  "])


@st.composite
def files(draw: st.DrawFn) -> str:
    numbers = draw(st.lists(st.integers(1, 60) | st.integers(1, 10**17), unique=True))
    text = ["DATA;"]
    for number in numbers:
        values = ",".join(draw(st.lists(_PIECES, max_size=4)))
        a, b, c, d = (draw(_GAPS) for _ in range(4))
        text.append(f"{a}#{number}{b}={c}{draw(_CLASSES)}{d}({values});")
    return "".join((*text, "ENDSEC;"))


@given(files())
def test_records_are_those_of_the_pattern(text: str) -> None:
    expected = by_pattern(text)
    found = records(text)
    assert [
        (found.name(i), found.kinds[found.kind(i)], found.inner(i)) for i in range(len(found))
    ] == [(f"#{name}", kind, inner) for name, kind, inner in expected]
    for i, (name, *_) in enumerate(expected):
        assert found.find(int(name)) == i
    assert found.find(61) == next((i for i, r in enumerate(expected) if r[0] == "61"), MISSING)
    for kind in {r[1].upper() for r in expected} | {"IFCPLATE"}:
        of = [i for i, r in enumerate(expected) if r[1].upper() == kind]
        assert found.of(kind).tolist() == of
        assert found.inners(found.of(kind)).texts() == [expected[i][2] for i in of]
        for texts in (("1.",), ("'a;b'", "'it''s'"), ("'Ж'", "''", "#2,$,#2,$")):
            assert found.beginning(kind, texts) == {
                found.name(i): expected[i][2] for i in of if expected[i][2].startswith(texts)
            }


@given(files(), st.integers(0, 10**6), st.sampled_from([";", "'", "(", "=", "#", "x", ""]))
def test_a_damaged_file_has_the_records_of_the_pattern_or_is_refused(
    text: str, place: int, by: str
) -> None:
    at = 5 + place % (len(text) - 12 + 1)
    text = text[:at] + by + text[at + 1 :]
    try:
        found = records(text)
    except Malformed:
        return
    assert [(found.name(i), found.inner(i)) for i in range(len(found))] == [
        (f"#{int(name)}", inner) for name, _, inner in by_pattern(text)
    ]


_REFERENCE = st.sampled_from(["#1", "#2", "#77", "$"])


@given(st.lists(st.tuples(_REFERENCE, _REFERENCE)), st.booleans())
def test_references_are_found_in_columns(pairs: list[tuple[str, str]], sparse: bool) -> None:
    first = 10**6 if sparse else 100
    made = [f"#{first + i}=IFCX({a},{b});" for i, (a, b) in enumerate(pairs)]
    found = records("".join(("DATA;#1=IFCY();#2=IFCY();", *made, "ENDSEC;")))
    index = {"#1": 0, "#2": 1, "#77": MISSING, "$": NONE_GIVEN}
    columns = found.references(found.of("IFCX"), 2)
    assert columns is not None
    assert [column.tolist() for column in columns] == [
        [index[pair[side]] for pair in pairs] for side in (0, 1)
    ]


def test_a_record_begins_behind_blanks() -> None:
    found = records("DATA;#1=IFCX( \n'abc','d');#2=IFCX('abd');#3=IFCX('ab');ENDSEC;")
    assert found.beginning("IFCX", ("'abc'", "'ab'")) == {"#1": "'abc','d'", "#3": "'ab'"}


@pytest.mark.parametrize(
    "values", ["#1", "#1,#2,$", "#1 ,#2", "#1, #2", "#1,*", "#1,$5", "#1,#", "1,2", "(#1,#2)"]
)
def test_other_values_are_no_columns(values: str) -> None:
    found = records(f"DATA;#1=IFCY();#2=IFCX(#1,$);#3=IFCX({values});ENDSEC;")
    assert found.references(found.of("IFCX"), 2) is None


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
    assert Tokens(lambda name, number: name).values(inner(text)["#7"]) == tuple(values)


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
            if len(mine.type.places):
                assert mine.is_a() == entity.is_a()
        else:
            assert mine == plain(entity)
        count += 1
    assert count > 20


@pytest.mark.parametrize(
    ("values", "listed"),
    [
        ("'g(#1',$,'S',$,(#2,#3)", ["#2", "#3"]), ("'g',$,'S',$,( #2,\r\n#3 ) ", ["#2", "#3"]),
        ("'g',$,'S',$,()", [""]),
    ],
)  # fmt: skip
def test_names_are_listed_without_blanks(values: str, listed: list[str]) -> None:
    file = File(f"{HEAD}#2=IFCPROPERTYSET({values});{TAIL}", "IFC4")
    assert file.entity("#2").listed == listed


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
    tokens = Tokens(lambda name, number: ("record", number))
    assert tokens.values(inner) == tokens._nested(inner)


@given(_TEXTS, _BARE, _TEXTS, st.lists(st.integers(1, 99), min_size=1, max_size=4))
def test_a_relation_is_read_as_any_record(
    guid: str, owner: str, name: str, many: list[int]
) -> None:
    inner = f"{guid},{owner},{name},$,({','.join(f'#{i}' for i in many)}),#200"
    tokens = Tokens(lambda name, number: ("record", number))
    assert tokens.values(inner) == tokens._nested(inner)


_NUMBERS = st.lists(
    st.sampled_from(["0.", "1.", "-2.5", "1.E-05", "-1.5E3", "2", "0.1", "12345.678", "-0."])
)


@given(
    st.lists(_NUMBERS),
    st.lists(st.tuples(*[st.integers(0, 9)] * 3)),
    st.sampled_from(["", "#901=IFCDIRECTION((+1.,0.));", "#901=IFCAXIS2PLACEMENT3D(#1 ,$,$);"]),
)
def test_points_and_placements_are_their_numbers(
    points: list[list[str]], placements: list[tuple[int, ...]], unusual: str
) -> None:
    known = {i: tuple(map(float, numbers)) for i, numbers in enumerate(points, 1)}
    text = [f"#{i}=IFCCARTESIANPOINT(({','.join(n)}));" for i, n in enumerate(points, 1)]
    expected: dict[int, Any] = dict(known)
    for i, sides in enumerate(placements, 501):
        written = ",".join(f"#{s}" if s in known else "$" for s in sides)
        text.append(f"#{i}=IFCAXIS2PLACEMENT3D({written});")
        expected[i] = tuple(known.get(s) for s in sides)
    file = File("".join(("DATA;", *text, unusual, "ENDSEC;")), "IFC4")
    assert {i: file.tokens[f"#{i}"] for i in expected} == expected
    with pytest.raises(LookupError, match="#902, which is not in the file"):
        assert file.tokens["#902"].label
    if "DIRECTION" in unusual:
        assert file.tokens["#901"] == (1.0, 0.0)


@given(
    st.lists(_TEXTS | _BARE, min_size=1),
    st.sampled_from(["", "()", "(#1,'x')", "T(1.)", "T()", "(T(1))"]),
    st.lists(_TEXTS | _BARE),
    st.sampled_from(["", " "]),
)
def test_values_with_one_list_are_read_as_any(
    before: list[str], middle: str, behind: list[str], blank: str
) -> None:
    inner = f",{blank}".join((*before, *[middle] * bool(middle), *behind))
    tokens = Tokens(lambda name, number: ("record", number))
    assert tokens.values(inner) == tokens._nested(inner)
