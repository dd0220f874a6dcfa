"""Plain entities taken in bulk and the same entities read by ezdxf make equal readings."""

import io
import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.readers import Reading, dxf
from beamcam.readers.dxf import load
from tests.conftest import CORPUS, examples
from tests.dxf_text import block, drawing, insert, layer_table, tags

SAMPLES = sorted((Path(__file__).parents[2] / "samples").rglob("*.dxf"))
FILES = [
    *SAMPLES,
    *(pytest.param(path, marks=pytest.mark.third_party)
      for path in sorted((CORPUS / "dxf").glob("*.dxf"))),
]  # fmt: skip


def both(data: bytes, **options: object) -> tuple[Reading, Reading]:
    """The reading with plain entities in bulk, and the one that ezdxf gives alone."""
    fast = dxf.read(data, "a.dxf", **options)  # type: ignore[arg-type]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(load, "take_plain", lambda *_: None)
        return fast, dxf.read(data, "a.dxf", **options)  # type: ignore[arg-type]


def assert_same(data: bytes, **options: object) -> None:
    fast, slow = both(data, **options)
    assert repr(fast) == repr(slow)  # tells -0.0 from 0.0 as well


def taken(data: bytes) -> int:
    """How many entities of a file are taken in bulk."""
    text = data.decode()
    found = load.take_plain(text, "AC1009" if "AC1009" in text else "AC1015", "\n5\n" in text)
    return 0 if found is None else sum(map(len, found.runs))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_read_the_same(path: Path) -> None:
    data = path.read_bytes()
    assert_same(data)
    assert_same(data, units="in", layers=("0", "CUT"))


# --- drawings written by hand ---------------------------------------------------------------------

reals = st.one_of(
    st.floats(-1e4, 1e4),
    st.integers(-100, 100),
    st.sampled_from(["0", "-0.0", "1e-9", " 12.5 ", "1_0", "+3", "1e300", "nan", "1e400", "x", ""]),
)
sound = st.floats(-1e4, 1e4)
names = st.sampled_from(["0", "CUT", "cut", "OFF", "Defpoints", "not in the table", "Ö"])
wholes = st.sampled_from([0, 1, 3, 7, 255, 256, 257, -1, "1.0", "x", " 5"])


@st.composite
def common(draw: st.DrawFn) -> list[tuple[int, object]]:
    """What any entity may say: of all rows a few, in any order."""
    rows = [
        (8, draw(names)),
        (62, draw(wholes)),
        (420, draw(st.sampled_from([255, 0xFF8000, "x"]))),
        (60, draw(st.sampled_from([0, 1, 0]))),
        (6, "DASHED"),
        (370, draw(st.sampled_from([25, -1, "thick"]))),
        (48, draw(st.sampled_from([1.0, "wide"]))),
        (67, draw(st.sampled_from([0, 1]))),
        (999, "a remark"),
    ]
    weights = [8, 5, 2, 1, 1, 1, 1, 1, 1]
    dice = random.Random(draw(st.integers(0, 2**16)))
    chosen = [row for row, weight in zip(rows, weights, strict=True) if dice.random() < weight / 10]
    dice.shuffle(chosen)
    return chosen


@st.composite
def numbered(draw: st.DrawFn, codes: tuple[int, ...]) -> list[tuple[int, object]]:
    """A value for each code; one in ten entities has odd ones."""
    numbers = reals if draw(st.integers(0, 9)) == 0 else sound
    return [(code, draw(numbers)) for code in codes]


@st.composite
def own_rows(draw: st.DrawFn, kind: str) -> list[list[tuple[int, object]]]:
    """The rows of a kind of entity, one list a subclass."""
    z = draw(st.booleans())
    point = (10, 20, 30) if z else (10, 20)
    second = (11, 21, 31) if z else (11, 21)
    match kind:
        case "LINE" | "POINT":
            return [draw(numbered(point + (second if kind == "LINE" else ())))]
        case "CIRCLE":
            return [draw(numbered((*point, 40)))]
        case "ARC":
            return [draw(numbered((*point, 40))), draw(numbered((50, 51)))]
        case "ELLIPSE":
            rows = draw(numbered((*point, *second)))
            shape = (draw(st.floats(0.01, 1)), draw(st.floats(0, 7)), draw(st.floats(0, 7)))
            return [[*rows, *zip((40, 41, 42), shape, strict=True)]]
        case "LWPOLYLINE":
            count = draw(st.integers(0, 4))
            rows = [(90, count), (70, draw(st.sampled_from([0, 1, 129])))]
            rows += draw(st.sampled_from([[], [(38, 2.5)], [(43, 0.1)], [(42, 1.0)]]))
            for _ in range(count):
                rows += draw(numbered((10, 20)))
                rows += draw(st.sampled_from([[], [(42, 0.5)], [(40, 0.1), (41, 0)], [(42, -1)]]))
            return [rows]
        case _:
            count, degree = draw(st.integers(1, 6)), draw(st.integers(1, 4))
            rows = [(70, 8), (71, degree), (73, count)]
            rows += draw(st.sampled_from([[], [(42, 1e-9), (43, 1e-9)], [(42, 0)], [(42, 0.5)]]))
            start = draw(st.sampled_from([0, 0, -2, 1.25]))
            more = count + degree + 1 + draw(st.sampled_from([0, 0, 0, 1]))
            step = draw(st.sampled_from([0, 1, 1, 1 / 3]))
            rows += [(40, start + k * step) for k in range(more)]
            rows += draw(st.sampled_from([[], [], [(41, 1)] * count, [(41, 0.5)]]))
            for k in range(count):
                rows += draw(numbered(point))
                rows += [(41, k + 1)] if draw(st.integers(0, 20)) == 0 else []
            return [rows]


extras = st.sampled_from(
    [[]] * 8
    + [
        [(210, 0.0), (220, 0.0), (230, 1.0)],
        [(210, 0.0), (220, -0.0), (230, 1.0)],
        [(210, 0.0), (220, 0.0), (230, -1.0)],
        [(210, 0.0), (220, 0.6), (230, 0.8)],
        [(39, 3.0)],
        [(39, "thick")],
        [(38, 3.0)],
        [(8, "CUT")],
        [(30, 7.0)],
    ]
)
tails = st.sampled_from(
    [[]] * 8
    + [
        [(1001, "ACAD"), (1000, "text"), (1070, 3), (1040, 1.5), (1071, 9)],
        [(1001, "ACAD"), (1070, "three")],
        [(1001, "ACAD"), (1010, 1.0), (1020, 2.0), (1030, 3.0)],
        [(1000, "no name before")],
        [(101, "Embedded Object"), (70, 1)],
    ]
)
heads = st.sampled_from(
    [[]] * 6
    + [
        [(102, "{ACAD_REACTORS"), (330, "A0"), (330, "A1"), (102, "}")],
        [(102, "{ACAD_XDICTIONARY"), (360, "A0"), (102, "}")],
        [(102, "{ACAD_REACTORS"), (330, "A0")],
        [(330, "1F")],
        [(330, "1B")],
        [(330, "1F"), (330, "1B")],
    ]
)
kinds = st.sampled_from(
    ["LINE", "LINE", "CIRCLE", "ARC", "ELLIPSE", "LWPOLYLINE", "SPLINE", "POINT"]
)


@st.composite
def entity_text(draw: st.DrawFn, handle: str, layered: bool) -> str:
    kind = draw(kinds)
    named = [(5, handle)] if draw(st.integers(0, 30)) else []
    parts = draw(own_rows(kind))
    parts[-1] = [*parts[-1], *draw(extras)]
    head = [(0, kind), *named]
    if not layered:
        return tags(*head, *draw(common()), *(row for part in parts for row in part))
    rows = [*head, *draw(heads), (100, "AcDbEntity"), *draw(common())]
    for part in parts:
        rows += [(100, "AcDb" + kind.title()), *part]
    return tags(*rows, *draw(tails))


others = st.sampled_from(
    [
        tags((0, "TEXT"), (5, "F1"), (8, "0"), (10, 0), (20, 0), (40, 2), (1, "word")),
        insert("B", 5, 5).replace("\nAB\n", "\nF2\n"),
        insert("B", 5, 5, (66, 1)).replace("\nAB\n", "\nF2\n"),
        tags((0, "POLYLINE"), (5, "F3"), (8, "0"), (66, 1), (70, 1))
        + "".join(
            tags((0, "VERTEX"), (5, f"F{k}"), (8, "0"), (10, k), (20, k * k)) for k in (4, 5, 6)
        )
        + tags((0, "SEQEND"), (5, "F7"), (8, "0")),
        tags((0, "POLYLINE"), (5, "F8"), (8, "0"), (66, 1), (70, 1)),
    ]
)


@st.composite
def documents(draw: st.DrawFn) -> bytes:
    """A drawing of plain and other entities, in one of five versions."""
    version = draw(st.sampled_from(["AC1009", "AC1012", "AC1015", "AC1021", "AC1032"]))
    layered = version != "AC1009" or draw(st.integers(0, 9)) == 0
    same = draw(st.integers(0, 20)) == 0  # all entities of one name
    text = ""
    for k in range(draw(st.integers(1, 8))):
        if draw(st.integers(0, 3)) == 0:
            text += draw(others)
        text += draw(entity_text("AA" if same else f"D{k}", layered))
    content = draw(entity_text("E0", layered))
    tables = layer_table(("CUT", 1, 0, 1), ("OFF", -3, 0, 1))
    data = drawing(text, tables=tables, blocks=block("B", content), version=version)
    if draw(st.booleans()):
        data = data.replace(b"\n", b"\r\n")
    return data


@settings(max_examples=examples(150), deadline=None)
@given(documents())
def test_drawings_by_hand_read_the_same(data: bytes) -> None:
    assert_same(data)


@settings(max_examples=examples(60), deadline=None)
@given(documents(), st.randoms(use_true_random=False))
def test_damaged_drawings_read_the_same(data: bytes, dice: random.Random) -> None:
    rows = data.split(b"\n")
    i, j = dice.randrange(len(rows)), dice.randrange(len(rows))
    match dice.randrange(4):
        case 0:
            del rows[i : i + dice.randint(1, 3)]
        case 1:
            rows.insert(i, rows[j])
        case 2:
            rows[i], rows[j] = rows[j], rows[i]
        case _:
            rows[i] = dice.choice([b"", b"-1", b"nan", b"0", b"ENDSEC", b"\xff", b"EOF", b"67"])
    assert_same(b"\n".join(rows))


SMALL = [p for p in SAMPLES if p.name in ("badge-cm.dxf", "gasket-inch.dxf", "layers.dxf")]
FRAME = [b"", b"-1", b"nan", b"0", b"ENDSEC", b"\xff", b"EOF", b"67", b"100", b"10", b"LAYER", b"2"]


@settings(max_examples=examples(60), deadline=None)
@given(st.sampled_from(SMALL), st.randoms(use_true_random=False))
def test_files_damaged_around_their_entities_read_the_same(path: Path, dice: random.Random) -> None:
    rows = path.read_bytes().replace(b"\r\n", b"\n").split(b"\n")
    assert load.load_document(b"\n".join(rows), Source("a")).document is None  # without ezdxf
    i, j = (dice.randrange(rows.index(b"ENTITIES")) for _ in "ij")
    match dice.randrange(4):
        case 0:
            del rows[i : i + dice.randint(1, 3)]
        case 1:
            rows.insert(i, rows[j])
        case 2:
            rows[i], rows[j] = rows[j], rows[i]
        case _:
            rows[i] = dice.choice(FRAME)
    assert_same(b"\n".join(rows))


# --- drawings written by ezdxf --------------------------------------------------------------------


def by_ezdxf(version: str, dice: random.Random) -> bytes:
    import ezdxf

    document = ezdxf.new(version)
    document.header["$INSUNITS"] = 4
    document.layers.add("CUT", color=3)
    space = document.modelspace()
    for _ in range(30):
        x, y, r = (dice.uniform(-500, 500) for _ in range(3))
        style = {"layer": dice.choice(["0", "CUT", "NEW"]), "color": dice.choice([1, 0, 256])}
        space.add_line((x, y), (r, x), dxfattribs=style)
        space.add_circle((x, y, dice.choice([0, 5])), abs(r), dxfattribs=style)
        space.add_arc((x, y), abs(r), x, y, dxfattribs=style)
        if dice.random() < 0.1:
            space.add_text("word", dxfattribs=style)
        if version != "R12":
            space.add_lwpolyline([(x, y, 0.5), (y, r, 0), (r, x, -1)], "xyb", close=r > 0)
            space.add_ellipse((x, y), (r, 1), dice.uniform(0.1, 1), 0.5, 3)
            space.add_spline([(x, y), (y, x), (r, y), (x, r)])
            space.add_open_spline([(x, y), (y, x), (r, y), (x, r), (0, 0)])
            space.add_rational_spline([(x, y), (y, x), (r, y), (x, r)], [1, 2, 3, abs(r) + 1])
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode()


@pytest.mark.parametrize("version", ["R12", "R2000", "R2004", "R2007", "R2010", "R2013", "R2018"])
def test_drawings_by_ezdxf_read_the_same_and_are_taken(version: str) -> None:
    data = by_ezdxf(version, random.Random(version))
    assert_same(data)
    assert taken(data) >= (90 if version == "R12" else 210)
