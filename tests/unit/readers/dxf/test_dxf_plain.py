"""Which entities are taken from the lines of a file, and which are left to ezdxf."""

import pytest

from beamcam.readers.dxf.load import MARKER, Taken, take_plain
from tests.dxf_text import arc, block, circle, drawing, entity, insert, line, polyline, spline, tags

TEXT = tags((0, "TEXT"), (5, "F1"), (8, "0"), (10, 0), (20, 0), (40, 2), (1, "word"))
CLAMPED = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def take(data: bytes, version: str = "AC1015", named: bool = True) -> Taken | None:
    return take_plain(data.decode(), version, named)


def kinds(data: bytes, **how: object) -> list[list[str]]:
    found = take(data, **how)  # type: ignore[arg-type]
    return [] if found is None else [[plain.kind for plain in run] for run in found.runs]


@pytest.mark.parametrize(
    "text",
    [
        line(0, 0, 1, 1),
        circle(0, 0, 1),
        circle(0, 0, 1, (210, 0), (220, 0), (230, 1)),
        arc(0, 0, 1, 0, 90),
        polyline([(0, 0, 1), (1, 1)]),
        spline(SQUARE, CLAMPED),
        spline(SQUARE, CLAMPED, weights=(1, 2, 2, 1)),
        spline(SQUARE, CLAMPED, fit=((0, 0), (1, 1))),
        line(0, 0, 1, 1) + tags((1001, "ACAD"), (1070, 3)),
        line(0, 0, 1, 1, common=((62, 1), (6, "DASHED"), (370, 25))),
    ],
)
def test_plain_entities_are_taken(text: str) -> None:
    assert kinds(drawing(text)) == [[text.split("\n")[1]]]


@pytest.mark.parametrize(
    "text",
    [
        TEXT,
        insert("B"),
        circle(0, 0, 1, (210, 0), (220, 0), (230, -1)),
        circle(0, 0, 1, (8, "again")),
        circle(0, 0, 1, (777, "unknown")),
        line(0, 0, 1, "nan"),  # type: ignore[arg-type]
        line(0, 0, 1, "word"),  # type: ignore[arg-type]
        line(0, 0, 1, 1, common=((67, 1),)),
        line(0, 0, 1, 1, common=((62, "red"),)),
        line(0, 0, 1, 1, common=((370, "thick"),)),
        line(0, 0, 1, 1) + tags((1001, "ACAD"), (1004, "00")),
        entity("LINE", "AcDbLine", (10, 0), (11, 1), (20, 0), (21, 1)),
        entity("LINE", "AcDbLine", (10, 0), (20, 0)),
        line(0, 0, 1, 1).replace("\nAB\n", "\nno number\n"),
        tags((0, "CIRCLE"), (5, "AB"), (100, "AcDbCircle"), (10, 0), (20, 0), (40, 1)),
        spline(SQUARE, CLAMPED[1:]),
        spline(SQUARE, CLAMPED, weights=(1, 2)),
        spline([], [], fit=((0, 0), (1, 1))),
        spline(SQUARE, [3.0] * 8),
    ],
)
def test_others_are_left_to_ezdxf(text: str) -> None:
    assert kinds(drawing(circle(9, 9, 9) + text.replace("\nAB\n", "\nAC\n"))) == [["CIRCLE"]]


def test_a_marker_stands_where_a_run_was() -> None:
    found = take(drawing(line(0, 0, 1, 1) + circle(0, 0, 1) + TEXT + arc(0, 0, 1, 0, 90)))
    assert found is not None
    assert [[p.kind for p in run] for run in found.runs] == [["LINE", "CIRCLE"], ["ARC"]]
    rest = found.rest.split("\n")
    order = [rest[k + 1] for k in range(0, len(rest) - 1, 2) if rest[k] == "0"]
    assert order[-6:] == ["SECTION", MARKER, "TEXT", MARKER, "ENDSEC", "EOF"]


@pytest.mark.parametrize(
    "data",
    [
        drawing(line(0, 0, 1, 1).replace("5\nAB\n", "")),  # a name that ezdxf has to invent
        drawing(line(0, 0, 1, 1), blocks=block("AB", "").replace("B1", "AB")),  # two of one name
        drawing(tags((0, "POLYLINE"), (5, "F1"), (66, 1)) + line(0, 0, 1, 1)),  # no vertices
        drawing(insert("B", 0, 0, (66, 1)).replace("AB", "F1") + line(0, 0, 1, 1)),
        drawing(line(0, 0, 1, 1)).replace(b"EOF\n", b"EOF\n0\nEOF\n"),
        drawing(line(0, 0, 1, 1)).replace(b"EOF\n", b""),
        drawing(line(0, 0, 1, 1)).replace(b"10\n0\n", b"ten\n0\n"),
        drawing(line(0, 0, 1, 1)).replace(b"ENTITIES", b"ENTRIES"),
        drawing(line(0, 0, 1, 1)).replace(b"AcDbLine", MARKER.encode()),
    ],
)
def test_a_file_where_something_is_odd_is_one_for_ezdxf(data: bytes) -> None:
    assert take(data) is None


def test_r12_has_lines_arcs_and_circles_without_subclasses() -> None:
    flat = tags((0, "LINE"), (8, "0"), (10, 0), (20, 0), (11, 1), (21, 1))
    flat += tags((0, "CIRCLE"), (62, 1), (10, 0), (20, 0), (40, 1))
    old = drawing(flat + polyline([(0, 0), (1, 1)]), version="AC1009")
    assert kinds(old, version="AC1009", named=False) == [["LINE", "CIRCLE"]]
