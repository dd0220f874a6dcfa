"""What relations tie to elements, however they are written."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc.entities import features_of, tied
from beamcam.readers.ifc.records import Entity, File

ELEMENTS = "".join(f"#{i}=IFCBEAM('g{i}',$,$,$,$,$,$,$);\n" for i in range(1, 6))
SETS = "".join(f"#{i}=IFCPROPERTYSET('g{i}',$,'S',$,());\n" for i in range(11, 15))


def file_of(relations: str) -> File:
    head = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC2X3'));\nENDSEC;\nDATA;\n"
    return File(f"{head}{ELEMENTS}{SETS}{relations}ENDSEC;\nEND-ISO-10303-21;\n", "IFC2X3")


def names_of(file: File, name: str, what: str) -> list[str]:
    """What is tied to an element, by its names; `$` is nothing."""
    return ["$" if one is None else one.name for one in tied(element(file, name), what)]


def element(file: File, name: str) -> Entity:
    found: Entity = file.entity(int(name[1:]))
    assert found.is_a("IfcBeam")
    return found


_TEXT = st.sampled_from(["$", "'a'", "'(#1),#11'", "',(#1),#11'", "'it''s, (b'", "'a;\n'"])
_NAME = st.sampled_from([f"#{i}" for i in range(1, 6)])
_SET = st.sampled_from([f"#{i}" for i in range(11, 15)])
_BETWEEN = st.sampled_from([",", ",", " , ", ",\n"])


@given(st.lists(st.tuples(_TEXT, st.lists(_NAME, min_size=1, unique=True), _SET, _BETWEEN)))
def test_property_sets_are_tied_to_the_elements_of_their_relations(
    drawn: list[tuple[str, list[str], str, str]],
) -> None:
    made = [
        f"#{i}=IFCRELDEFINESBYPROPERTIES('g',$,{text},{text}{b}({b.join(names)}){b}{one});\n"
        for i, (text, names, one, b) in enumerate(drawn, 100)
    ]
    file = file_of("".join(made))
    for i in range(1, 6):
        expected = [one for _, names, one, _ in drawn if f"#{i}" in names]
        assert names_of(file, f"#{i}", "definitions") == expected


@pytest.mark.parametrize(
    ("relation", "what", "expected"),
    [
        ("IFCRELAGGREGATES('g',$,$,$,#3,(#1,#2))", "wholes", {"#1": ["#3"], "#2": ["#3"]}),
        ("IFCRELAGGREGATES('g',$,$,'x', #3 ,(#1))", "wholes", {"#1": ["#3"]}),
        ("IFCRELNESTS('g',$,'(#2','a,#4',#3,(#1))", "wholes", {"#1": ["#3"]}),
        ("IFCRELASSOCIATESMATERIAL('g',$,$,$,(#1),#13)", "materials", {"#1": ["#13"]}),
        ("IFCRELASSOCIATESMATERIAL('g',$,$,$,(#1),$)", "materials", {"#1": ["$"]}),
        ("IFCRELDEFINESBYTYPE('g',$,$,$,(#1,#5),#13)", "types", {"#1": ["#13"], "#5": ["#13"]}),
        ("IFCRELDEFINESBYPROPERTIES('g',$,$,$,#1,#13)", "definitions", {"#1": ["#13"]}),
        ("IFCRELDEFINESBYPROPERTIES('g',$,$,$,(),#13)", "definitions", {}),
        ("IFCRELOVERRIDESPROPERTIES('g',$,$,$,(#1),#11,(#12))", "definitions", {"#1": ["#11"]}),
        ("IFCRELDEFINESBYPROPERTIES('g',$,$,$,(#1,#99),#98)", "definitions", {"#1": ["#98"]}),
    ],
)
def test_relations_of_each_kind(relation: str, what: str, expected: dict[str, list[str]]) -> None:
    file = file_of(f"#100={relation};\n")
    for i in range(1, 6):
        assert names_of(file, f"#{i}", what) == expected.get(f"#{i}", [])


def test_nothing_is_tied_to_what_is_not_there() -> None:
    with pytest.raises(LookupError, match="#99, which is not in the file"):
        tied(file_of("").entity(99), "materials")


def test_a_relation_that_is_cut_short_is_no_relation() -> None:
    file = file_of("#100=IFCRELDEFINESBYPROPERTIES('g',$,$);\n")
    with pytest.raises(LookupError):
        tied(element(file, "#1"), "definitions")


def test_openings_of_which_one_cannot_be_told_are_none_for_any_member() -> None:
    """An index of those before it would leave holes out of all but the first member."""
    rows = "#100=IFCRELVOIDSELEMENT('g',$,$,$,#1,#3);\n#101=IFCRELVOIDSELEMENT('g',$,$,$);\n"
    file = file_of(f"{rows}#102=IFCRELVOIDSELEMENT('g',$,$,$,#2,#4);\n")
    for name in ("#1", "#2", "#2"):
        with pytest.raises(LookupError):
            features_of(element(file, name), "openings")


def test_an_opening_that_is_not_named_is_none_of_its_host_alone() -> None:
    rows = "#100=IFCRELVOIDSELEMENT('g',$,$,$,#1,#3);\n#101=IFCRELVOIDSELEMENT('g',$,$,$,#2);\n"
    file = file_of(rows)
    assert features_of(element(file, "#1"), "openings") == [file.entity(3)]
    assert features_of(element(file, "#2"), "openings") == [None]
