"""Laws of the SVG reader: what a file says in another way is the same drawing."""

import io
import random
import re
from math import isfinite
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from beamcam.errors import Diagnostic
from beamcam.geometry.plane import determinant, mapped
from beamcam.model.lengths import total_length
from beamcam.model.part import extent
from beamcam.readers import svg
from beamcam.readers.svg.page import parse_transform
from beamcam.readers.svg.path import parse_path
from beamcam.readers.svg.tree import _rules, _without_comments, _without_statements, declarations
from tests.conftest import examples
from tests.svg_text import curves_of, drawing

SAMPLES = sorted((Path(__file__).parents[2] / "samples").rglob("*.svg"))
HUGE = [path for path in SAMPLES if path.stem == "svg-uses"]

numbers = st.integers(-20_000, 20_000).map(lambda n: n / 100)
words = numbers.map(lambda n: f"{n:g}")
flags = st.sampled_from("01")
sizes = st.integers(1, 9_000).map(lambda n: f"{n / 100:g}")


def command(name: str, *parts) -> st.SearchStrategy[str]:
    return st.tuples(*parts).map(lambda values: name + " ".join(values))


commands = st.one_of(
    *(command(name, words, words) for name in "LlTt"),
    *(command(name, words) for name in "HhVv"),
    *(command(name, *[words] * 6) for name in "Cc"),
    *(command(name, *[words] * 4) for name in "SsQq"),
    *(command(name, sizes, sizes, words, flags, flags, words, words) for name in "Aa"),
    st.sampled_from(["z", "Z"]),
    *(command(name, words, words) for name in "Mm"),
)
paths = st.tuples(words, words, st.lists(commands, max_size=8)).map(
    lambda t: f"M{t[0]} {t[1]}l7 11" + "".join(t[2])  # a path of no length is none
)
shapes = st.one_of(
    paths.map(lambda d: f'<path d="{d}"/>'),
    st.builds(lambda x, y, r: f'<circle cx="{x}" cy="{y}" r="{r}"/>', words, words, sizes),
    st.builds(
        lambda x, y, a, b: f'<ellipse cx="{x}" cy="{y}" rx="{a}" ry="{b}"/>',
        *(words, words, sizes, sizes),
    ),
    st.builds(
        lambda x, y, w, h, r: f'<rect x="{x}" y="{y}" width="{w}" height="{h}" rx="{r}"/>',
        *(words, words, sizes, sizes, sizes),
    ),
    st.builds(
        lambda row: '<polygon points="' + " ".join(",".join(p) for p in row) + ' "/>',
        st.lists(st.tuples(words, words), min_size=2, max_size=6, unique=True),
    ),
)
#: svgelements continues a cubic by T and a quadratic by S, which the standard does not.
MIXED = re.compile("[CcSs][^A-Za-z]*[Tt]|[QqTt][^A-Za-z]*[Ss]")

turns = st.one_of(
    st.builds(lambda a: f"rotate({a})", st.integers(-400, 400)),
    st.builds(lambda x, y: f"translate({x} {y})", words, words),
    st.builds(lambda x: f"scale({x})", sizes),
    st.builds(lambda x, y: f"scale({x} {y})", sizes, sizes),
    st.builds(lambda a: f"skewX({a})", st.integers(-60, 60)),
    st.builds(lambda row: f"matrix({' '.join(row)})", st.tuples(*[words] * 6)),
)


@settings(max_examples=examples(150), deadline=None)
@given(paths)
def test_paths_are_those_of_svgelements(d: str) -> None:
    from svgelements import Close, Move, Path

    assume(not MIXED.search(d))
    theirs = [s for s in Path(d) if not isinstance(s, Move)]
    theirs = [s for s in theirs if not isinstance(s, Close) or s.start is not None]
    ours = [curve for subpath in parse_path(d) for curve in subpath]
    theirs = [s for s in theirs if s.start != s.end or s.length(error=1e-3) > 1e-6]
    assert len(ours) == len(theirs)
    for a, b in zip(ours, theirs, strict=True):
        size = 1e-6 * max(1.0, *(abs(v) for v in extent([a])))
        assert a.start == pytest.approx((b.start.x, b.start.y), abs=size)
        assert a.end == pytest.approx((b.end.x, b.end.y), abs=size)
        middle = b.point(0.5)
        assert a.point(0.5) == pytest.approx((middle.x, middle.y), abs=10 * size)


@settings(max_examples=examples(100), deadline=None)
@given(st.lists(turns, max_size=4), st.tuples(numbers, numbers))
def test_transforms_are_those_of_svgelements(row: list[str], point: tuple[float, float]) -> None:
    from svgelements import Matrix

    x, y = Matrix(" ".join(row)).point_in_matrix_space(point)
    assert mapped(parse_transform(" ".join(row)), point) == pytest.approx(
        (x, y), rel=1e-6, abs=1e-4
    )


@settings(max_examples=examples(60), deadline=None)
@given(shapes, turns)
def test_a_transform_maps_every_point(shape: str, text: str) -> None:
    matrix = parse_transform(text)
    (a, b, _), (d, e, _) = matrix
    assume(abs(determinant(matrix)) > 1e-3 * (a * a + b * b + d * d + e * e))
    plain = curves_of(shape)
    moved = curves_of(f'<g transform="{text}">{shape}</g>')
    assert len(plain) == len(moved)
    size = max(1.0, *(abs(v) for v in extent(moved) or (1.0,)))
    for before, after in zip(plain, moved, strict=True):
        for t in (0.0, 0.5, 1.0):
            x, y = before.point(t)
            u, v = mapped(matrix, (x, 100 - y))
            assert after.point(t) == pytest.approx((u, 100 - v), abs=1e-6 * size)


@settings(max_examples=examples(60), deadline=None)
@given(shapes, st.sampled_from([("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("px96", 25.4 / 96)]))
def test_a_unit_scales_the_drawing(shape: str, unit: tuple[str, float]) -> None:
    name, mm = unit
    plain = total_length(curves_of(shape, units="mm"))
    scaled = total_length(curves_of(shape, units=name, head='viewBox="0 0 100 100"'))
    assert scaled == pytest.approx(mm * plain, rel=1e-9)


@settings(max_examples=examples(20), deadline=None)
@given(shapes)
def test_lengths_are_those_of_svgelements(shape: str) -> None:
    from svgelements import SVG, Move, Shape
    from svgelements import Path as Theirs

    assume("<path" not in shape or not MIXED.search(shape.split(chr(34))[1]))
    page = SVG.parse(io.BytesIO(drawing(shape)), reify=True, ppi=96)
    expected = 0.0
    for element in page.elements():
        if isinstance(element, Shape):
            segments = (s for s in Theirs(element) if not isinstance(s, Move))
            expected += sum(s.length(error=1e-6) for s in segments) * 25.4 / 96
    # Near a cusp the lengths of svgelements are off by 1e-4 of themselves, whatever its `error`.
    assert total_length(curves_of(shape)) == pytest.approx(expected, rel=1e-3, abs=1e-6)


@settings(max_examples=examples(200), deadline=None)
@given(st.sampled_from([p for p in SAMPLES if p not in HUGE]), st.randoms(use_true_random=False))
def test_no_damage_makes_the_reader_raise(path: Path, dice: random.Random) -> None:
    """Bytes of a file are lost, doubled or overwritten: a reading or a refusal."""
    data = bytearray(path.read_bytes())
    for _ in range(dice.randint(1, 3)):
        i = dice.randrange(len(data) or 1)
        match dice.randrange(4):
            case 0:
                del data[i : i + dice.randint(1, 9)]
            case 1:
                data[i:i] = data[i : i + 20]
            case 2:
                data[i : i + 1] = dice.choice([b"9", b"-", b"%", b"z", b"e", b" ", b".", b"\xff"])
            case _:
                data[i : i + 3] = dice.choice([b"nan", b"1e9", b"---", b"url"])
    reading = svg.read(bytes(data), "a.svg")
    assert all(isinstance(d, Diagnostic) for d in reading.diagnostics)
    assert reading.parts or reading.refused
    for contour in (c for part in reading.parts for c in part.contours):
        assert all(isfinite(v) for c in contour.curves for v in (*c.start, *c.end))


@settings(max_examples=examples(20), deadline=None)
@given(st.sampled_from([p for p in SAMPLES if "bad" not in p.parts]))
def test_reading_twice_says_the_same(path: Path) -> None:
    data = path.read_bytes()
    assert svg.read(data, "a.svg") == svg.read(data, "a.svg")


# --- style rules ----------------------------------------------------------------------------------


sheets = st.lists(
    st.sampled_from(
        ["/*", "*/", "*", "/", "a", ".b", "{", "}", ";", "@import", "@charset", "@font", " ", "!",
         "important", "IMPORTANT", "<!--", "-->", ":", "\n", "red", "\t"]
    ),
    max_size=30,
).map("".join)  # fmt: skip


@given(sheets)
def test_comments(text: str) -> None:
    plain = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    assert _without_comments(text) == plain.replace("<!--", " ").replace("-->", " ")


@given(sheets)
def test_statements(text: str) -> None:
    assert _without_statements(text) == re.sub(r"@(?:import|charset|namespace)[^;{]*;", " ", text)


@given(sheets)
def test_rules(text: str) -> None:
    assert list(_rules(text)) == re.findall(r"([^{}]*)\{([^{}]*)\}", text)


@given(sheets)
def test_declarations(text: str) -> None:
    important = re.compile(r"\s*!\s*important\s*\Z", re.IGNORECASE)
    wanted = []
    for part in text.split(";"):
        name, colon, value = part.partition(":")
        if colon:
            plain = important.sub("", value)
            wanted.append((name.strip().lower(), plain.strip(), plain != value))
    assert list(declarations(text)) == wanted
