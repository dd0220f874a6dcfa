"""What a DXF file says about its unit, and what it must not be trusted with."""

import struct

import pytest

from beamcam.readers import dxf
from beamcam.readers.drawing import INSUNITS
from beamcam.readers.dxf import header_number
from tests.dxf_text import box_of, codes, drawing, entity, insert, polyline, tags
from tests.dxf_text import section as a_section

MM = {1: 25.4, 2: 304.8, 4: 1.0, 5: 10.0, 6: 1000.0, 8: 25.4e-6, 9: 0.0254, 10: 914.4, 13: 1e-3}
MM |= {14: 100.0, 21: 304.8006096012192}


def square(side: float) -> str:
    return polyline([(0, 0), (side, 0), (side, side), (0, side)])


@pytest.mark.parametrize(("code", "mm"), MM.items())
def test_a_square_of_100_mm_in_each_unit(code: int, mm: float) -> None:
    box = box_of(drawing(square(100 / mm), units=code))
    assert box == pytest.approx((0, 0, 100, 100), abs=1e-9)


@pytest.mark.parametrize("units", [None, 0])
def test_no_unit_is_said_and_taken_for_mm(units: int | None) -> None:
    data = drawing(square(100), units=units)
    assert codes(data) == ["dxf-units-missing"]
    assert box_of(data) == (0, 0, 100, 100)


def test_a_file_without_header_is_not_in_metres() -> None:
    data = (a_section("ENTITIES", square(100)) + tags((0, "EOF"))).encode()
    said = dxf.read(data, "a.dxf").diagnostics
    assert [str(d) for d in said] == [
        "a.dxf: warning dxf-units-missing: found no $INSUNITS, expected a unit; mm assumed, "
        "--units says another"
    ]
    assert box_of(data) == (0, 0, 100, 100)


def test_imperial_measurement_is_mentioned_where_the_unit_is_missing() -> None:
    data = drawing(square(1), (9, "$MEASUREMENT"), (70, 0), units=None)
    assert "$MEASUREMENT 0 (inches)" in dxf.read(data, "a.dxf").diagnostics[0].message


def test_corel_draws_in_centimetres_and_says_inches_too() -> None:
    data = drawing(square(10), (9, "$MEASUREMENT"), (70, 0), units=5)
    assert codes(data) == []
    assert box_of(data) == (0, 0, 100, 100)


@pytest.mark.parametrize("code", [-1, 18, 25, 77])
def test_a_unit_that_there_is_not_refuses_the_file(code: int) -> None:
    reading = dxf.read(drawing(square(1), units=code), "a.dxf")
    assert [d.code for d in reading.diagnostics] == ["dxf-units-unknown"]
    assert reading.parts == ()
    assert f"found $INSUNITS {code}, expected one of 1 inches" in reading.diagnostics[0].message


@pytest.mark.parametrize(("units", "size"), [("mm", 100), ("in", 2540), ("cm", 1000), ("IN", 2540)])
def test_the_user_knows_better(units: str, size: float) -> None:
    for code in (None, 0, 4, 77):
        data = drawing(square(100), units=code)
        assert codes(data, units=units) == []
        assert box_of(data, units=units) == pytest.approx((0, 0, size, size))


def test_a_unit_that_nobody_knows_is_refused() -> None:
    reading = dxf.read(drawing(square(1)), "a.dxf", units="cubit")
    assert reading.refused
    assert str(reading.diagnostics[0]).startswith(
        "a.dxf: error drawing-units-option: found unit 'cubit', expected one of um, mil, q, mm, "
    )


def test_feet_and_inches_shown_in_a_metric_drawing_are_mentioned() -> None:
    assert codes(drawing(square(9), (9, "$LUNITS"), (70, 4), units=4)) == ["dxf-units-feet"]
    assert codes(drawing(square(9), (9, "$LUNITS"), (70, 4), units=1)) == []


def test_a_drawing_of_a_hundred_metres_is_mentioned() -> None:
    reading = dxf.read(drawing(square(100), units=6), "a.dxf")
    assert str(reading.diagnostics[0]) == (
        "a.dxf: warning drawing-large: found a drawing of 100000 x 100000 mm in the unit metres; "
        "check the unit, --units overrides it"
    )
    assert codes(drawing(square(100), units=6), units="m") == []


def dimension(measured: float, text: str) -> str:
    own = ((2, "*D1"), (10, 0), (20, 0), (11, 0), (21, 0), (70, 0), (1, text), (42, measured))
    more = tags((100, "AcDbAlignedDimension"), (13, 0), (23, 0), (14, measured), (24, 0))
    return entity("DIMENSION", "AcDbDimension", *own) + more


@pytest.mark.parametrize(
    ("units", "measured", "text"),
    [
        (4, 3.937007874, "100 mm"),
        (None, 3.937007874, "100mm"),
        (6, 100, "100 mm"),
        (1, 100, "100 mm"),
        (4, 10, "{\\fArial|b0;10 cm}"),
        (4, 4, '4"'),
        (5, 25.4, "1 inch"),
    ],
)
def test_a_dimension_that_denies_the_unit_refuses_the_file(
    units: int | None, measured: float, text: str
) -> None:
    data = drawing(square(100) + dimension(measured, text), units=units)
    assert "dxf-units-contradict" in codes(data)
    assert "dxf-units-contradict" not in codes(data, units="mm")
    assert dxf.read(data, "a.dxf").refused


@pytest.mark.parametrize(
    ("units", "measured", "text"),
    [
        (4, 100, "100 mm"),
        (5, 10, "100 mm"),
        (1, 4, '4"'),
        (4, 50, "100 mm"),  # not to scale: no factor between two units
        (4, 3.937, "100"),  # names no unit
        (4, 100, ""),
        (4, 100, "R<>"),
        (1, 100, "see note"),
    ],
)
def test_other_dimensions_are_no_matter_of_units(units: int, measured: float, text: str) -> None:
    assert codes(drawing(square(100) + dimension(measured, text), units=units)) == ["dxf-not-cut"]


def test_a_style_that_appends_a_unit_counts() -> None:
    style = tags((0, "TABLE"), (2, "DIMSTYLE"), (5, "A"), (100, "AcDbSymbolTable"), (70, 1))
    style += tags((0, "DIMSTYLE"), (105, "D0"), (100, "AcDbSymbolTableRecord"))
    style += tags((100, "AcDbDimStyleTableRecord"), (2, "METRIC"), (70, 0), (3, "<> mm"))
    style += tags((144, 1.0), (0, "ENDTAB"))
    shown = dimension(100, "").replace("(42, ", "(42, ")
    with_style = shown.replace("70\n0\n", "70\n0\n3\nMETRIC\n", 1)
    assert codes(drawing(square(100) + with_style, units=4, tables=style)) == ["dxf-not-cut"]
    assert "dxf-units-contradict" in codes(drawing(square(100) + with_style, units=1, tables=style))


def test_units_of_binary_files_come_from_the_bytes() -> None:
    head = b"AutoCAD Binary DXF\r\n\x1a\x00"
    for value in (1, 4, 5):
        data = head + b"\x09\x00$INSUNITS\x00\x46\x00" + struct.pack("<h", value)
        assert header_number(data, "$INSUNITS") == value
    assert header_number(head + b"\x00\x00SECTION\x00", "$INSUNITS") is None


def test_a_variable_named_in_a_text_is_no_header() -> None:
    text = entity("TEXT", "AcDbText", (10, 0), (20, 0), (40, 1), (1, "$INSUNITS"))
    assert codes(drawing(square(1) + text, units=None)) == ["dxf-units-missing", "dxf-not-cut"]


def test_windows_and_old_line_ends_change_nothing() -> None:
    data = drawing(square(10), units=5)
    for end in (b"\r\n", b"\r"):
        assert box_of(data.replace(b"\n", end)) == (0, 0, 100, 100)


def test_units_of_the_table_are_those_of_the_standard() -> None:
    assert {code: mm for code, (_, mm) in INSUNITS.items() if code in MM} == pytest.approx(MM)


def test_inserts_are_in_the_unit_of_the_drawing() -> None:
    from tests.dxf_text import block

    data = drawing(insert("B", 1, 0), units=5, blocks=block("B", square(2)))
    assert box_of(data) == pytest.approx((10, 0, 30, 20))
