"""Units: a drawing, a page and a model of known size come out in millimetres."""

import pytest

from beamcam import readers
from beamcam.model.part import Part
from tests.conftest import SAMPLES
from tests.dxf_text import drawing, line

#: $INSUNITS by the DXF reference: 1 inches, 2 feet, 4 mm, 5 cm, 6 m, 9 mils, 13 microns, 14 dm.
DXF = {1: 25.4, 2: 304.8, 4: 1.0, 5: 10.0, 6: 1000.0, 9: 0.0254, 13: 0.001, 14: 100.0}


def width(part: Part) -> float:
    xs = [p[0] for c in part.contours for curve in c.curves for p in (curve.start, curve.end)]
    return max(xs) - min(xs)


@pytest.mark.parametrize("unit", DXF)
def test_a_drawing(unit: int) -> None:
    """A line that is 20 mm long."""
    (part,) = readers.read(drawing(line(0, 0, 20 / DXF[unit], 0), units=unit), "p.dxf").parts
    assert width(part) == pytest.approx(20)


#: CSS: an inch is 25.4 mm, 72 points and 6 picas.
SVG = {"1in": 25.4, "72pt": 25.4, "6pc": 25.4, "2.54cm": 25.4, "25.4mm": 25.4,
       "3in": 76.2}  # fmt: skip


@pytest.mark.parametrize("size", SVG)
def test_a_page(size: str) -> None:
    """A line over half of a page of that width, which holds 100 of its own units."""
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" '
        'viewBox="0 0 100 100"><path d="M10 10H60" stroke="#f00" fill="none"/></svg>'
    )
    (part,) = readers.read(text.encode(), "p.svg").parts
    assert width(part) == pytest.approx(SVG[size] / 2)


@pytest.mark.parametrize("name", ["beam_inch", "beam_openings"])
def test_a_model(name: str) -> None:
    """The geometry kernel gives metres, whatever the unit of the file: box of the whole beam."""
    import ifcopenshell
    import ifcopenshell.geom

    path = SAMPLES / "ifc" / f"{name}.ifc"
    model = ifcopenshell.open(str(path))
    parts = readers.read(path.read_bytes(), path.name).parts
    beams = {beam.GlobalId: beam for beam in model.by_type("IfcBeam")}
    assert parts
    for part in parts:
        shape = ifcopenshell.geom.create_shape(ifcopenshell.geom.settings(), beams[part.guid])
        v = shape.geometry.verts
        box = sorted(1000 * (max(v[k::3]) - min(v[k::3])) for k in range(3))
        sizes = sorted([part.length, part.profile.height, part.profile.width])
        assert sizes == pytest.approx(box, abs=0.01)
