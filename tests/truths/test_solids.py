"""Sections as the geometry kernel builds them, fillets and all, beside their areas by figures."""

import numpy as np
import pytest

from beamcam.model.part import Profile
from beamcam.model.section import section_area

LENGTH = 1000.0
#: IFC's profile with its figures, and ours: height, width, flange, web, radius.
SECTIONS = {
    "I": ("IfcIShapeProfileDef", {
        "OverallWidth": 150.0, "OverallDepth": 300.0, "WebThickness": 7.1, "FlangeThickness": 10.7,
        "FilletRadius": 15.0,
    }, (300.0, 150.0, 10.7, 7.1, 15.0)),
    "U": ("IfcUShapeProfileDef", {
        "Depth": 200.0, "FlangeWidth": 75.0, "WebThickness": 8.5, "FlangeThickness": 11.5,
        "FilletRadius": 11.5,
    }, (200.0, 75.0, 11.5, 8.5, 11.5)),
    # EN 10056-1: toes have half the radius of the root.
    "L": ("IfcLShapeProfileDef", {
        "Depth": 150.0, "Width": 100.0, "Thickness": 10.0, "FilletRadius": 12.0, "EdgeRadius": 6.0,
    }, (150.0, 100.0, 10.0, 10.0, 12.0)),
    "T": ("IfcTShapeProfileDef", {
        "Depth": 80.0, "FlangeWidth": 120.0, "WebThickness": 9.0, "FlangeThickness": 7.0,
        "FilletRadius": 8.0,
    }, (120.0, 80.0, 9.0, 7.0, 8.0)),
    "M": ("IfcRectangleHollowProfileDef", {
        "XDim": 120.0, "YDim": 80.0, "WallThickness": 5.0, "OuterFilletRadius": 10.0,
        "InnerFilletRadius": 5.0,
    }, (120.0, 80.0, 5.0, 5.0, 10.0)),
    "RO": ("IfcCircleHollowProfileDef", {"Radius": 57.15, "WallThickness": 5.0},
           (114.3, 114.3, 0.0, 5.0, 0.0)),
    "RU": ("IfcCircleProfileDef", {"Radius": 10.0}, (20.0, 20.0, 0.0, 0.0, 0.0)),
}  # fmt: skip


def volume(kind: str, figures: dict[str, float]) -> float:
    """mm3 of a metre of a profile: its triangles' tetrahedra with the origin."""
    import ifcopenshell
    import ifcopenshell.geom
    import ifcopenshell.guid

    make = ifcopenshell.file(schema="IFC4").create_entity
    place = make("IfcAxis2Placement3D", make("IfcCartesianPoint", (0.0, 0.0, 0.0)))
    unit = make("IfcSIUnit", None, "LENGTHUNIT", "MILLI", "METRE")
    context = make("IfcGeometricRepresentationContext", None, "Model", 3, 1e-5, place)
    make("IfcProject", ifcopenshell.guid.new(), RepresentationContexts=[context],
         UnitsInContext=make("IfcUnitAssignment", [unit]))  # fmt: skip
    middle = make("IfcAxis2Placement2D", make("IfcCartesianPoint", (0.0, 0.0)))
    profile = make(kind, ProfileType="AREA", Position=middle, **figures)
    up = make("IfcDirection", (0.0, 0.0, 1.0))
    solid = make("IfcExtrudedAreaSolid", profile, place, up, LENGTH)
    shape = make("IfcShapeRepresentation", context, "Body", "SweptSolid", [solid])
    beam = make("IfcBeam", ifcopenshell.guid.new(),
                ObjectPlacement=make("IfcLocalPlacement", None, place),
                Representation=make("IfcProductDefinitionShape", None, None, [shape]))  # fmt: skip
    settings = ifcopenshell.geom.settings()
    settings.set("mesher-linear-deflection", 0.00002)
    settings.set("mesher-angular-deflection", 0.05)
    built = ifcopenshell.geom.create_shape(settings, beam).geometry
    corners = 1000 * np.array(built.verts).reshape(-1, 3)  # the kernel gives metres
    a, b, c = (corners[np.array(built.faces)[k::3]] for k in range(3))
    return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6


@pytest.mark.parametrize("code", SECTIONS)
def test_an_area(code: str) -> None:
    kind, figures, ours = SECTIONS[code]
    area = section_area(Profile(code, "", *ours))  # type: ignore[arg-type]
    assert area == pytest.approx(volume(kind, figures) / LENGTH, rel=2e-4)
