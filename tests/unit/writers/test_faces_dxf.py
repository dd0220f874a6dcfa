"""The faces of a part as a drawing: layers, entities and labels."""

import io
from pathlib import Path

import ezdxf
import pytest

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, NewtonCurve
from beamcam.model.part import Contour, EndCuts, Hole, Part, Profile, Slot
from beamcam.readers.dstv import read
from beamcam.writers.faces_dxf import write

SAMPLES = sorted((Path(__file__).parents[3] / "samples" / "dstv").glob("*.nc1"))
HERE = Source("a.nc1", 1)
PLATE = Profile("B", "PL10*200", 200, 0, 0, 10)


def drawing_of(part):
    document = ezdxf.read(io.StringIO(write(part)))
    assert not document.audit().errors
    return document


def entities(part, layer):
    return [e for e in drawing_of(part).modelspace() if e.dxf.layer == layer]


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.stem)
def test_samples(path):
    (part,) = read(path.read_bytes(), path.name).parts
    document = drawing_of(part)
    space = document.modelspace()
    for face in {f.face for f in (*part.holes, *part.slots)} | {"v"}:
        layer = "FACE_" + face.replace("#", "-")
        circles = [e for e in space if e.dxf.layer == layer + "_HOLES" and e.dxftype() == "CIRCLE"]
        assert len(circles) == sum(
            h.face == face and h.kind != "mark" and h.diameter > 0 for h in part.holes
        )
        labels = [e.dxf.text for e in space if e.dxf.layer == layer + "_LABEL"]
        assert len(labels) == 1
        assert part.mark in labels[0]
    texts = [e.dxf.text for e in space if e.dxf.layer.endswith("_TEXT")]
    assert sorted(texts) == sorted(t.text for t in part.texts)


def test_same_on_every_run():
    part = Part("P1", PLATE, 300, HERE, features=(Hole("v", 10, 20, 18, HERE),))
    assert write(part) == write(part)
    assert ezdxf.options.write_fixed_meta_data_for_testing is False


def test_stock_is_drawn_where_no_contour_is():
    lines = entities(Part("P1", PLATE, 300, HERE), "FACE_v")
    assert [e.dxftype() for e in lines] == ["LINE"] * 4
    assert max(e.dxf.start.x for e in lines) == 300


def test_views_do_not_overlap():
    profile = Profile("I", "IPE300", 300, 150, 10.7, 7.1)
    features = tuple(Hole(face, 100, 75, 18, HERE) for face in "vou")
    document = drawing_of(Part("B1", profile, 1000, HERE, features=features))
    spans = {}
    for face in "vou":
        ys = [
            point.y
            for e in document.modelspace().query("LINE")
            if e.dxf.layer == f"FACE_{face}"
            for point in (e.dxf.start, e.dxf.end)
        ]
        spans[face] = (min(ys), max(ys))
    assert spans["u"][1] < spans["v"][0] < spans["v"][1] < spans["o"][0]


def test_slot_outline():
    slot = Slot("v", 100, 50, 20, 30, 10, 30, HERE)
    found = entities(Part("P1", PLATE, 300, HERE, features=(slot,)), "FACE_v_HOLES")
    arcs = [e for e in found if e.dxftype() == "ARC"]
    lines = [e for e in found if e.dxftype() == "LINE"]
    assert len(arcs) == len(lines) == 4
    ends = sorted(
        (round(p.x, 6), round(p.y, 6)) for a in arcs for p in (a.start_point, a.end_point)
    )
    assert ends == sorted(
        (round(p.x, 6), round(p.y, 6)) for e in lines for p in (e.dxf.start, e.dxf.end)
    )


CURVES = (
    (Line((0.0, 0.0), (10.0, 5.0)), "LINE"),
    (Arc((0.0, 0.0), 5.0, 30.0, -100.0), "ARC"),
    (Arc((0.0, 0.0), 5.0, 30.0, 360.0), "CIRCLE"),
    (EllipseArc((1.0, 2.0), (30.0, 5.0), 0.4, 10.0, -250.0), "ELLIPSE"),
    (Bezier(((0.0, 0.0), (10.0, 40.0), (50.0, -40.0), (60.0, 0.0))), "SPLINE"),
    (
        BSpline(2, ((0.0, 0.0), (10.0, 20.0), (30.0, 10.0)), (0, 0, 0, 1, 1, 1), (1.0, 0.5, 1.0)),
        "SPLINE",
    ),
    (NewtonCurve(((0.0, 0.0), (10.0, 20.0), (20.0, 10.0))), "SPLINE"),
)


@pytest.mark.parametrize(("curve", "kind"), CURVES, ids=lambda value: type(value).__name__)
def test_curves_are_drawn_exactly(curve, kind):
    contour = Contour("v", "open", (curve,), HERE, "punch", False)
    (entity,) = (
        e for e in entities(Part("P1", PLATE, 300, HERE, features=(contour,)), "FACE_v_MARKS")
    )
    assert entity.dxftype() == kind
    if kind != "SPLINE":
        return
    tool = entity.construction_tool()
    points = [tool.point(t * tool.max_t) for t in (0.0, 0.25, 0.5, 1.0)]
    shift = points[0].y - curve.start[1]
    for t, point in zip((0.0, 0.25, 0.5, 1.0), points, strict=True):
        x, y = curve.point(t)
        assert (point.x, point.y - shift) == pytest.approx((x, y))


def test_ends_that_only_the_header_cuts_are_drawn() -> None:
    """A flat mitred at 30 degrees, and a web between flanges mitred at 45: by hand."""
    source = Source("p.nc1", 1)

    flat = Part("F", Profile("B", "", 50.0, 0.0, 0.0, 5.0), 300.0, source, cuts=EndCuts(45.0))
    frame = Part("M", Profile("I", "", 180.0, 91.0, 8.0, 5.3, 9.0), 2200.0, source,
                 cuts=EndCuts(0.0, 0.0, -45.0, 45.0))  # fmt: skip
    for part, corners in (
        (flat, {(50.0, 0.0), (300.0, 0.0), (300.0, 50.0), (0.0, 50.0)}),
        (frame, {(48.15, 0.0), (2151.85, 0.0), (2151.85, 180.0), (48.15, 180.0)}),
    ):
        drawn = ezdxf.read(io.StringIO(write(part))).modelspace().query("LINE[layer=='FACE_v']")
        assert {(round(e.dxf.start.x, 6), round(e.dxf.start.y, 6)) for e in drawn} == corners
