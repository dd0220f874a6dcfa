"""`--fit newton=LAYER`: polylines of drawings as polynomials through their vertices."""

from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import errors_in
from beamcam.geometry.curves import Arc, Bezier, Line, NewtonCurve
from beamcam.readers import dxf, svg
from tests import svg_text
from tests.conftest import examples
from tests.dxf_text import circle, drawing, line, polyline, spline
from tests.runs import call

NODES = [(10.0, 11.0), (40.0, 22.0), (60.0, 20.0), (90.0, 5.0)]
BOX = [(0.0, 0.0), (100.0, 0.0), (100.0, 80.0), (0.0, 80.0)]


def on(layer: str, text: str) -> str:
    return text.replace("\n8\n0\n", f"\n8\n{layer}\n")


FILE = drawing(
    on("OUT", polyline(BOX))
    + on("CAM", polyline(NODES, False) + line(10, 30, 90, 30) + circle(50, 50, 5))
)


def read(data: bytes, *layers: str):
    return dxf.read(data, "a.dxf", fit=layers)


def test_a_polyline_becomes_a_polynomial_and_the_rest_stays():
    reading = read(FILE, "cam")
    box, curve, straight, round_one = (c.curves for c in reading.parts[0].contours)
    assert curve == (NewtonCurve(tuple(NODES)),)
    assert curve[0].end == (90, 5)
    assert len(box) == 4
    assert straight == (Line((10, 30), (90, 30)),)
    assert isinstance(round_one[0], Arc)
    assert [str(said) for said in reading.diagnostics] == [
        "a.dxf: note drawing-fitted: found 1 polylines on layer 'CAM', now polynomials through "
        "their vertices; 2 other contours there stay as they are drawn"
    ]


def test_the_read_part_is_as_large_as_its_curves():
    high = drawing(polyline([(0, 0), (10, 30), (90, 30), (100, 0)], False))
    (plain,), (fitted,) = dxf.read(high, "a.dxf").parts, read(high, "0").parts
    assert plain.profile.height == 30
    assert fitted.profile.height > 33
    assert fitted.length == plain.length


def test_a_closed_polyline_is_a_closed_polynomial():
    (contour,) = read(drawing(polyline(BOX)), "0").parts[0].contours
    (curve,) = contour.curves
    assert contour.closed
    assert isinstance(curve, NewtonCurve)
    assert curve.nodes == (*BOX, BOX[0])
    assert not curve.is_function


def test_splines_by_fit_points_are_nodes_too():
    data = drawing(spline([], [], fit=tuple(NODES)))
    (plain,), (fitted,) = dxf.read(data, "a.dxf").parts, read(data, "0").parts
    assert not isinstance(next(plain.contours).curves[0], NewtonCurve)
    assert next(fitted.contours).curves == (NewtonCurve(tuple(NODES)),)
    assert [d.code for d in read(data, "0").diagnostics] == ["drawing-fitted"]
    elsewhere = drawing(on("B", spline([], [], fit=tuple(NODES))) + polyline(BOX))
    assert [d.code for d in read(elsewhere, "0").diagnostics] == [
        "dxf-fit-spline", "drawing-fitted",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("layer", "found"),
    [("", "no layer"), ("CAN", "no layer 'can'"), ("HOLES", "no polylines on layer 'HOLES'")],
)
def test_a_layer_that_cannot_be_fitted_is_an_error_that_names_the_layers(layer, found):
    data = drawing(polyline(BOX) + on("HOLES", circle(50, 50, 5)))
    reading = read(data, layer)
    assert [str(d) for d in errors_in(reading.diagnostics)] == [
        f"a.dxf: error drawing-fit-layer: found {found}, expected --fit newton=LAYER with "
        "polylines on one of the layers '0', 'HOLES'"
    ]


def test_what_is_no_polynomial_is_refused():
    double = drawing(polyline([(0, 0), (1e8, 0), (1e8, 1e-9)], False))
    (said,) = errors_in(read(double, "0").diagnostics)
    assert said.code == "drawing-fit-nodes"
    assert "node (1e+08, 1e-09) is too near to the one before" in said.message
    zigzag = [(float(x), 10.0 * (x % 2)) for x in range(26)]
    codes = [d.code for d in read(drawing(polyline(zigzag, False)), "0").diagnostics]
    assert "polynomial-lost" in codes
    swinging = [(10.0 * x, 20 / (1 + x * x)) for x in range(-5, 6)]
    codes = [d.code for d in read(drawing(polyline(swinging, False)), "0").diagnostics]
    assert "polynomial-oscillates" in codes


def test_layers_of_svg_files():
    body = '<g id="Cam"><polyline points="10,11 40,22 60,20 90,5"/></g><path d="M0 0 L5 5 L9 0"/>'
    reading = svg_text.read(body, fit=("Cam",))
    first, second = reading.parts[0].contours
    assert isinstance(first.curves[0], NewtonCurve)
    assert first.curves[0].nodes[-1] == (90, 95)
    assert len(second.curves) == 2
    assert svg.read(svg_text.drawing(body), "a.svg", fit=("",)).refused


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(st.tuples(st.floats(-90, 90), st.floats(-90, 90)), min_size=3, max_size=6))
def test_every_vertex_is_on_the_polynomial(points):
    nodes = [(round(x, 3), round(y, 3)) for x, y in points]
    nodes = [p for k, p in enumerate(nodes) if k == 0 or p != nodes[k - 1]]
    reading = read(drawing(polyline(nodes, False)), "0")
    if len(nodes) < 3 or reading.refused:
        return
    (curve,) = next(reading.parts[0].contours).curves
    assert isinstance(curve, NewtonCurve)
    rising = all(a[0] < b[0] for a, b in pairwise(nodes))
    assert curve.is_function or not rising
    form = curve.as_bezier()
    assert isinstance(form, Bezier)
    for t, node in zip(curve.parameters, nodes, strict=True):
        assert curve.point(t) == node
        assert form.point(t) == pytest.approx(node, abs=1e-6)


def test_a_program_is_compared_with_the_polynomial(tmp_path: Path):
    file, program = tmp_path / "a.dxf", tmp_path / "a.ngc"
    file.write_bytes(FILE)
    fit = ("--fit", "newton=CAM", "--allow-open")
    assert call("post", file, *fit, "-o", program).exit_code == 0
    assert call("verify", program, "--against", file, *fit).exit_code == 0
    as_drawn = call("verify", program, "--against", file, "--allow-open", status=1)
    assert "verify-sheet-extra" in as_drawn.stderr
    out = tmp_path / "a.json"
    assert call("convert", file, "--fit", "newton=CAM", "-o", out).exit_code == 0
    assert '"newton"' in out.read_text()
    assert '"newton"' in call("inspect", file, "--fit", "newton=CAM", "--json").stdout


def test_the_option_by_itself_lists_the_layers(tmp_path: Path):
    file = tmp_path / "a.dxf"
    file.write_bytes(FILE)
    said = call("post", file, "--fit", "newton", "-o", tmp_path / "a.ngc", status=1)
    assert "one of the layers 'OUT', 'CAM'" in said.stderr
    wrong = call("post", file, "--fit", "lagrange=CAM", "-o", tmp_path / "a.ngc", status=2)
    assert "expected newton=LAYER" in wrong.stderr


def test_verify_takes_the_options_of_the_drawing(tmp_path: Path):
    file, program = tmp_path / "a.dxf", tmp_path / "a.ngc"
    file.write_bytes(FILE)
    options = ("--thickness", "3", "--units", "cm", "--map", "CAM=cut", "--allow-open")
    assert call("post", file, *options, "-o", program).exit_code == 0
    assert call("verify", program, "--against", file, *options).exit_code == 0
    assert call("verify", program, "--against", file).exit_code == 1
