"""Real and made DXF files against lengths and boxes computed without this project."""

import json
from itertools import pairwise

import pytest

from beamcam.errors import errors_in
from beamcam.model.lengths import total_length
from beamcam.model.part import extent
from beamcam.readers import dxf
from tests.conftest import CORPUS

FOLDER = CORPUS / "dxf"
TRUTH = json.loads((FOLDER / "truth.json").read_text())["files"] if FOLDER.exists() else {}
USABLE = sorted(name for name, truth in TRUTH.items() if truth["usable"])
UNMARKED = "trimesh_spline_1.dxf"  #: ezdxf refuses it
UNUSABLE = sorted(name for name, truth in TRUTH.items() if not truth["usable"])

#: The reference counts these as visible; here they are hidden, since nothing plots on them.
NOT_PLOTTING = ("Defpoints", "NOPLOT")
#: The reference draws this periodic spline over all of its knots, where its basis functions do
#: not add up to 1 and the curve leaves the control polygon for (38, 62). See the last test.
PERIODIC = "synth_ellipse_spline.dxf"

pytestmark = pytest.mark.third_party


def read(name: str):
    return dxf.read((FOLDER / name).read_bytes(), name)


@pytest.mark.parametrize("name", [n for n in USABLE if n != PERIODIC])
def test_length_and_box_are_those_of_the_reference(name: str) -> None:
    truth, reading = TRUTH[name], read(name)
    assert errors_in(reading.diagnostics) == ()
    (part,) = reading.parts
    assert part.measures is not None
    curves = [curve for contour in part.contours for curve in contour.curves]
    unseen = sum(truth["length_by_layer_mm"].get(layer, 0.0) for layer in NOT_PLOTTING)
    length = truth["length_xy_mm"] - unseen
    assert total_length(curves) == pytest.approx(length, rel=1e-5, abs=1e-4)
    hidden = truth["hidden_length_mm"] + unseen
    assert total_length(part.measures.hidden) == pytest.approx(hidden, abs=1e-3)
    if not unseen:
        assert extent(curves) == pytest.approx(truth["bbox_mm"], abs=1e-4)
    assert dict(part.measures.not_cut) == truth["not_cut"]


@pytest.mark.parametrize("name", USABLE)
def test_length_by_layer(name: str) -> None:
    if name == PERIODIC:
        return
    by_layer: dict[str, list] = {}
    for contour in read(name).parts[0].contours:
        by_layer.setdefault(contour.layer or "", []).extend(contour.curves)
    found = {layer: total_length(curves) for layer, curves in by_layer.items()}
    expected = TRUTH[name]["length_by_layer_mm"]
    assert found == pytest.approx(
        {k: v for k, v in expected.items() if k not in NOT_PLOTTING}, rel=1e-5, abs=1e-4
    )


@pytest.mark.parametrize("name", USABLE)
def test_a_missing_unit_is_said(name: str) -> None:
    missing = "dxf-units-missing" in [d.code for d in read(name).diagnostics]
    assert missing == TRUTH[name]["unit_source"].startswith("missing")


def test_polylines_without_subclass_markers_are_read_and_told() -> None:
    """Lengths are those of the vertices of its three polylines, a line and an arc, in inches."""
    reading = read(UNMARKED)
    assert "dxf-subclasses" in [d.code for d in reading.diagnostics]
    rows = [row.strip() for row in (CORPUS / "dxf" / UNMARKED).read_text("latin-1").splitlines()]
    tags = list(zip(rows[::2], rows[1::2], strict=True))
    chains: list[list[complex]] = []
    for k, (code, value) in enumerate(tags):
        if code == "0":
            chains.append([])
            inside = value == "LWPOLYLINE"
        elif code == "10" and inside:
            chains[-1].append(complex(float(value), float(tags[k + 1][1])))
    straight = [
        sum(abs(b - a) for a, b in pairwise(chain)) * 25.4 for chain in chains if len(chain) > 1
    ]
    (part,) = reading.parts
    found = [total_length(c.curves) for c in part.contours if len(c.curves) > 1]
    assert len(found) == 3
    for length, expected in zip(sorted(found), sorted(straight), strict=True):
        assert length == pytest.approx(expected, rel=0.25)  # one of them closes


@pytest.mark.parametrize("name", [n for n in UNUSABLE if n != UNMARKED])
def test_what_cannot_be_used_is_refused_with_a_reason(name: str) -> None:
    reading = read(name)
    assert reading.refused
    assert {d.code for d in errors_in(reading.diagnostics)} <= {"dxf-structure", "drawing-empty"}


def test_a_periodic_spline_is_the_closed_curve_between_its_inner_knots() -> None:
    from ezdxf import readfile

    reading = read(PERIODIC)
    assert not reading.refused
    *_, periodic = reading.parts[0].contours
    assert periodic.closed
    tool = list(readfile(FOLDER / PERIODIC).modelspace())[-1].construction_tool()
    low, high = tool.knots()[tool.degree], tool.knots()[tool.count]
    points = [tool.point(low + (high - low) * k / 20000) for k in range(20001)]
    length = sum(a.distance(b) for a, b in pairwise(points))
    assert total_length(periodic.curves) == pytest.approx(length, rel=1e-6)
    others = [c for contour in list(reading.parts[0].contours)[:-1] for c in contour.curves]
    by_type = TRUTH[PERIODIC]["length_by_type_mm"]
    assert total_length(others) == pytest.approx(by_type["ELLIPSE"] + 15.70796, rel=1e-6)
