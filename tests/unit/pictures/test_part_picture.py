"""Pictures of parts: what the model has is there once, in true proportions."""

from itertools import pairwise
from math import atan2, degrees
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.model.part import Contour, EndPlane, Hole, Part, Slot, TextMark
from beamcam.pictures.formats import to_svg
from beamcam.pictures.part import faces_of, part_scene
from beamcam.pictures.scene import Polyline
from beamcam.pictures.views import spread
from beamcam.pipeline import read_file
from tests.conftest import SAMPLES, examples
from tests.unit.pictures.drawings import NAMESPACE, Drawing, corners

FILES = sorted(
    path
    for pattern in ("dstv/*.nc1", "dxf/*.dxf", "svg/*.svg", "json/*.json")
    for path in SAMPLES.glob(pattern)
)  # fmt: skip


def part_of(path: Path) -> Part:
    return read_file(str(path), units="mm").parts[0]


def drawn(part: Part) -> Drawing:
    return Drawing(to_svg(part_scene(part)))


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.name)
def test_each_feature_is_drawn_once(path: Path) -> None:
    part = part_of(path)
    found = drawn(part)
    marks = sum(1 for h in part.holes if h.kind == "mark" or not h.diameter)
    assert found.count("hole") == sum(1 for _ in part.holes) - marks
    assert found.count("mark", "cross") == marks
    assert found.count("slot") == sum(1 for _ in part.slots)
    assert found.count("contour") == sum(1 for _ in part.contours)
    assert found.count("text") == sum(1 for _ in part.texts)
    for process in ("cut", "mark", "engrave", "punch", "powder"):
        wanted = sum(1 for c in part.contours if c.process == process)
        assert found.count("contour", f"by-{process}") == wanted
    is_bar = part.profile.code != "B" and part.measures is None
    planes = sum(isinstance(f, EndPlane) for f in part.features)
    assert found.count("cut") == (2 if is_bar else 0) + planes
    texts = " ".join(found.texts)
    assert part.mark in texts
    assert part.profile.name in texts


@pytest.mark.parametrize("path", FILES[:4], ids=lambda p: p.name)
def test_the_same_part_gives_the_same_bytes(path: Path) -> None:
    assert to_svg(part_scene(part_of(path))) == to_svg(part_scene(part_of(path)))


def test_proportions_are_true() -> None:
    part = part_of(SAMPLES / "dstv" / "gusset.nc1")
    found = drawn(part)
    outer, inner = (corners(found.all("contour", k)[0]) for k in ("outer", "inner"))
    wide = max(x for x, _ in outer) - min(x for x, _ in outer)
    high = max(y for _, y in outer) - min(y for _, y in outer)
    assert wide / high == pytest.approx(part.length / part.profile.height, rel=1e-3)
    scale = wide / part.length
    first, second = (float(c.get("cx", 0)) for c in found.all("hole"))
    radius = float(found.all("hole")[0].get("r", 0))
    holes = list(part.holes)
    assert first - second == pytest.approx((holes[0].x - holes[1].x) * scale, abs=0.02)
    assert radius == pytest.approx(holes[0].diameter / 2 * scale, abs=0.01)
    assert min(x for x, _ in inner) > min(x for x, _ in outer)


def test_a_mitre_is_drawn_as_it_is_sawn() -> None:
    part = part_of(SAMPLES / "dstv" / "channel.nc1")
    start, end = (corners(e) for e in drawn(part).all("cut"))
    (x0, y0), (x1, y1) = start
    assert part.cuts.web_start
    # tan = x(lowest) - x(highest) over the height, whatever the scale
    assert degrees(atan2(x0 - x1, y0 - y1)) == pytest.approx(part.cuts.web_start, abs=0.1)
    assert end[0][0] == end[1][0]


def test_dimensions_show_each_place_along_x() -> None:
    part = part_of(SAMPLES / "dstv" / "channel.nc1")
    found = Drawing(to_svg(part_scene(part)))
    shown = [float(e.get("data-mm", "nan")) for e in found.root.iter(f"{NAMESPACE}text")]
    for feature in part.features:
        if isinstance(feature, Hole | Slot):
            assert feature.x in shown
    assert part.length in shown
    gusset = Drawing(to_svg(part_scene(part_of(SAMPLES / "dstv" / "gusset.nc1"))))
    edges = {"0", "20", "80", "100", "150", "180", "240", "260"}
    assert edges <= set(gusset.texts)
    inches = Drawing(to_svg(part_scene(part, "inch")))
    assert f"{part.length / 25.4:.3f}".rstrip("0") in inches.texts


def test_odd_marks_are_spelled_out() -> None:
    part = part_of(SAMPLES / "dstv" / "channel.nc1")
    text = to_svg(part_scene(replace(part, mark="<M&1>\x1b\u202e")))
    assert "<M&1>\\x1b\\u202e" in " ".join(Drawing(text).texts)


def test_faces_of_a_section_are_all_drawn() -> None:
    part = replace(part_of(SAMPLES / "dstv" / "channel.nc1"), features=())
    assert faces_of(part) == ("o", "v", "u")
    assert faces_of(replace(part, profile=replace(part.profile, code="M"))) == ("h", "o", "v", "u")
    assert drawn(part).count("face") == 3


def test_no_shape_lies_off_the_paper() -> None:
    for path in FILES:
        scene = part_scene(part_of(path))
        for shape in scene.shapes:
            if isinstance(shape, Polyline) and shape.classes.split()[0] != "text":
                for x, y in shape.points:
                    assert -1.0 <= x <= scene.width + 1.0, (path, shape)
                    assert -1.0 <= y <= scene.height + 1.0, (path, shape)


@given(st.lists(st.floats(0.0, 900.0), max_size=40).map(sorted), st.floats(0.1, 15.0))
@settings(max_examples=examples(30))
def test_labels_keep_apart_and_in_order(ideal: list[float], gap: float) -> None:
    found = spread(ideal, gap)
    assert len(found) == len(ideal)
    for a, b in pairwise(found):
        assert b - a >= gap - 1e-9
    if all(b - a >= gap for a, b in pairwise(ideal)):
        assert found == pytest.approx(ideal)


def test_kinds_of_features_are_all_known() -> None:
    """A part with one of each: nothing is left out of the picture."""
    part = part_of(SAMPLES / "dstv" / "channel.nc1")
    source = part.source
    line = next(part_of(SAMPLES / "dstv" / "gusset.nc1").contours).curves[:1]
    features = (
        Hole("v", 100, 50, 14, source), Hole("v", 200, 50, 14, source, kind="thread"),
        Hole("v", 300, 50, 14, source, kind="countersink"), Hole("v", 400, 50, 0, source),
        Slot("v", 500, 50, 14, 20, 0, 0, source), TextMark("v", 600, 50, 0, 10, "M1", source),
        Contour("v", "open", line, source, "mark", False),
        Contour("h", "open", line, source, "powder", False),
    )  # fmt: skip
    found = drawn(replace(part, features=features))
    assert [found.count(c) for c in ("hole", "thread", "slot", "text", "contour")] == [
        3, 2, 1, 1, 2,
    ]  # fmt: skip


def test_a_drawing_is_drawn_by_the_processes_of_its_machine() -> None:
    part = part_of(SAMPLES / "svg" / "corel-x6.svg")
    red, blue = "#ed3237", "#0000ff"
    assert sorted(c.colour or "" for c in part.contours) == [blue, red, red, red]
    table = {"red": "cut", "blue": "mark"}
    found = Drawing(to_svg(part_scene(part, processes=table)))
    assert [found.count("contour", f"by-{p}") for p in ("cut", "mark", "ignored")] == [3, 1, 0]
    found = Drawing(to_svg(part_scene(part, processes={"red": "engrave", "blue": "ignore"})))
    assert [found.count("contour", f"by-{p}") for p in ("engrave", "ignored")] == [3, 1]
    assert {"engrave", "ignored"} <= set(found.texts)


def test_cutting_planes_are_drawn_where_they_cross_the_web() -> None:
    part = part_of(SAMPLES / "dstv" / "channel.nc1")
    plane = EndPlane((1000.0, 0.0, 0.0), (1.0, 0.5, 0.0), part.source)
    along = EndPlane((0.0, 100.0, 0.0), (0.0, 1.0, 0.0), part.source)
    found = drawn(replace(part, features=(plane, along)))
    start, end, cut = (corners(e) for e in found.all("cut"))
    scale = (end[0][0] - start[1][0]) / part.length
    assert (cut[0][0] - start[1][0]) / scale == pytest.approx(1000.0, abs=0.1)
    assert (cut[0][0] - cut[1][0]) / scale == pytest.approx(part.profile.height / 2, abs=0.1)
    assert "1 cutting planes along the part are not drawn" in found.texts
