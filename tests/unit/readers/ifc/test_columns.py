"""Records of a class that are read together: as they are read one by one."""

import gc
from typing import Any
from weakref import ref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc.characters import Places, codes_of
from beamcam.readers.ifc.columns import Alike
from beamcam.readers.ifc.records import File, Missing
from beamcam.readers.ifc.step import Inners, Malformed
from beamcam.readers.ifc.values import Tokens

REFERENCES = st.integers(1, 99).map(lambda number: f"#{number}")
PLAIN = st.sampled_from(
    ["$", "*", ".T.", ".AREA.", "1.5", "-3", "1.E-05", "''", "'a b'", "'Ж'", "'ф'", " #5", "#7 "]
)
ODD = st.sampled_from(
    ["'a,b'", "'a,;,b'", "'it''s'", "'(a)'", "'a", ";", "", "abc", "#x", "#1#2", "3#4"]
)
LISTS = st.sampled_from(["(#1)", "()", "((#1))", "T(1.)", ")"])


SHAPES = st.sampled_from(
    ["(T(?))", "(?,T(?))", "((?),(?,?))", "T(?)", "(?,?)", "(T(?),(?))", "t2(?)", "?"]
)


def referred(numbers: Places) -> list[Any] | None:
    return None if 99 in numbers else [("record", number) for number in numbers.tolist()]


def read(inners: list[str]) -> list[Any] | None:
    """The values of records together."""
    text = f"{'DATA;':8}({');('.join(inners)});"
    last = np.cumsum([len(inner) + 3 for inner in inners]) + 6
    first = last - np.array(list(map(len, inners)))
    marks = np.array([i for i, letter in enumerate(text) if letter in "(),;"], np.int64)
    opened, closed = np.searchsorted(marks, first - 1), np.searchsorted(marks, last)
    of = Inners(text, codes_of(text), marks, opened, closed)
    assert of.texts() == inners
    return Alike(tokens(), referred).values(of)


def tokens() -> Tokens:
    return Tokens(lambda name, number: ("record", number))


def one_by_one(inners: list[str]) -> list[Any]:
    """As `Tokens.values` gives them, or Malformed."""
    found: list[Any] = []
    for inner in inners:
        try:
            found.append(tokens().values(inner))
        except Malformed:
            found.append(Malformed)
    return found


@st.composite
def alike(draw: st.DrawFn) -> list[str]:
    """Records of equally many values, each place with its own sort; with one list, or none."""
    sorts = draw(st.lists(st.sampled_from([REFERENCES, PLAIN]), min_size=1, max_size=4))
    where = draw(st.none() | st.integers(0, len(sorts)))
    inners = []
    for _ in range(draw(st.integers(1, 5))):
        values = [draw(sort) for sort in sorts]
        if where is not None:
            listed = draw(st.lists(draw(st.sampled_from([REFERENCES, PLAIN])), min_size=1))
            values.insert(where, f"({','.join(listed)})")
        inners.append(",".join(values))
    return inners


@given(alike())
def test_records_that_are_alike_are_read_as_one_by_one(inners: list[str]) -> None:
    found = read(inners)
    assert found == one_by_one(inners)


@given(st.lists(SHAPES, min_size=1, max_size=3), st.integers(1, 4), st.data())
def test_lists_in_lists_and_types_are_read_as_one_by_one(
    shapes: list[str], count: int, data: st.DataObject
) -> None:
    sorts = [data.draw(st.sampled_from([REFERENCES, PLAIN])) for _ in shapes]
    inners = []
    for _ in range(count):
        written = []
        for shape, sort in zip(shapes, sorts, strict=True):
            head, *rest = shape.split("?")
            written.append(head + "".join(data.draw(sort) + piece for piece in rest))
        inners.append(",".join(written))
    assert read(inners) == one_by_one(inners)


@given(st.lists(st.lists(REFERENCES | PLAIN | ODD | LISTS, max_size=4).map(",".join), min_size=1))
def test_what_is_read_together_is_never_another_value(inners: list[str]) -> None:
    found = read(inners)
    assert found is None or found == one_by_one(inners)


@pytest.mark.parametrize(
    "inners",
    [
        ["#1", ""], ["", ""], [",(#1)"], ["(#1),"], ["#1,(#2)", "(#2),#1"], ["(#1)#2"],
        ["#1", "#1,#1", "#1,#1,#1", "#1,#1,#1,#1", "#1,#1,#1,#1,#1"],
        ["(#1),(#2,#3)", "(#1,#2),(#3)"], ["(#1)(#2)"], ["#1(#2)"], [".A.(#2)"], ["(#1", "(#2"],
        ["#1)"], [")#1("], ["()"], ["T()"], ["T(#1)", "(#1)"], ["#1", "(T())"], ["#1#2"], ["abc"],
        ["'a,b'"], ["'it''s'"], ["'(a)'"], ["#1,#2", "()"],
    ],
)  # fmt: skip
def test_other_records_are_left_to_be_read_one_by_one(inners: list[str]) -> None:
    assert read(inners) is None


@pytest.mark.parametrize(
    "inners",
    [
        ["#1,#2", "#1"], ["#1", "(#1),#2", "#2"], ["#1,#2", "(#1)"],
        ["(#1),(#2),.T.", "(T(1.)),(T(#2)),.F.", "(#2),(#1),.F."],
    ],
)  # fmt: skip
def test_records_of_few_ways_are_read_way_by_way(inners: list[str]) -> None:
    found = read(inners)
    assert found is not None
    assert found == one_by_one(inners)


@pytest.mark.parametrize("values", [["'Ж'", "'ф'"], ["'?'", "'ф'"], ["'?'", "'?'"], ["$", "$"]])
def test_a_value_that_all_records_share_is_theirs_alone(values: list[str]) -> None:
    assert read(values) == one_by_one(values)


HOLES = "#1=IFCDIRECTION((0.,0.,1.));#3=IFCCIRCLEPROFILEDEF(.AREA.,$,$,9.);"


@pytest.mark.parametrize(
    ("faulty", "fault"),
    [
        ("#8=IFCEXTRUDEDAREASOLID(#3,$,abc,4.);", Malformed),
        ("#8=IFCEXTRUDEDAREASOLID(#3,$,#7,4.);#7=IFCDIRECTION((.A.));", ValueError),
        ("#8=IFCEXTRUDEDAREASOLID(#3,$,#7,4.);#7=IFCDIRECTION($);", Malformed),
        ("#8=IFCEXTRUDEDAREASOLID(#3,$,#7,4.);#7=IFCDIRECTION();", Malformed),
    ],
)
def test_a_record_that_is_no_values_spoils_no_other(faulty: str, fault: type[Exception]) -> None:
    text = f"DATA;{HOLES}#5=IFCEXTRUDEDAREASOLID(#3,$,#1,4.);{faulty}ENDSEC;"
    for first in ("#5", "#8"):
        file = File(text, "IFC4")
        for name in (first, "#5", "#8"):
            entity = file.entity(name)
            if name == "#8":
                with pytest.raises(fault):
                    entity.values[2]
            else:
                assert entity.values == (file.entity("#3"), None, (0.0, 0.0, 1.0), 4.0)


def test_a_reference_to_no_record_fails_when_it_is_looked_at() -> None:
    text = f"DATA;{HOLES}#5=IFCEXTRUDEDAREASOLID(#3,$,#1,4.);#8=IFCEXTRUDEDAREASOLID(#9,$,#1,4.);"
    file = File(text + "ENDSEC;", "IFC4")
    assert file.entity("#5").values[0] is file.entity("#3")
    missing = file.entity("#8").values[0]
    assert isinstance(missing, Missing)
    assert missing.name == "#9"
    with pytest.raises(LookupError, match="#9, which is not in the file"):
        missing.type  # noqa: B018


def test_a_closed_file_goes_at_once_with_entities_that_lead_back_to_themselves() -> None:
    file = File("DATA;#1=IFCBOOLEANRESULT(.UNION.,#2,#2);#2=IFCCSGSOLID(#1);ENDSEC;", "IFC4")
    ring = file.entity("#1")
    assert ring.FirstOperand.TreeRootExpression is ring
    gone = ref(file)
    gc.disable()  # which is to have nothing to do
    try:
        file.close()
        del file, ring
        assert gone() is None
    finally:
        gc.enable()
