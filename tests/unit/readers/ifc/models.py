"""Small models for the tests: one element from a body, with what is said of it."""

from beamcam.errors import Source
from beamcam.readers.ifc.entities import Model, open_file
from tests.property.ifc_builder import Step, Vec

ORIGIN: Vec = (0.0, 0.0, 0.0)


def opened(data: bytes) -> Model:
    """The model of a file that is well formed."""
    model = open_file(data, Source("m.ifc"))
    assert isinstance(model, Model), model
    return model


class Small:
    """A model in mm to which bodies, elements and properties are added."""

    def __init__(self, schema: str = "IFC4", unit: str = "mm") -> None:
        self.step = Step(schema, unit)
        self.add = self.step.add
        self.flat = self.add(f"IFCAXIS2PLACEMENT2D({self.add('IFCCARTESIANPOINT((0.,0.))')},$)")
        self.placement = self.add(f"IFCLOCALPLACEMENT($,{self.step.world})")

    def ipe300(self) -> str:
        return self.add(f"IFCISHAPEPROFILEDEF(.AREA.,$,{self.flat},150.,300.,7.1,10.7,15.,$,$)")

    def extruded(self, profile: str, depth: float, at: str | None = None) -> str:
        """A solid along local x, the profile's x along local y; or at a placement of its own."""
        at = at or self.step.axes(ORIGIN, (1, 0, 0), (0, 1, 0))
        up = self.step.direction(0, 0, 1)
        return self.add(f"IFCEXTRUDEDAREASOLID({profile},{at},{up},{self.step.length(depth)})")

    def circle(self, diameter: float) -> str:
        return self.add(
            f"IFCCIRCLEPROFILEDEF(.AREA.,$,{self.flat},{self.step.length(diameter / 2)})"
        )

    def box(self, x: float, y: float) -> str:
        size = self.step.length(x), self.step.length(y)
        return self.add(f"IFCRECTANGLEPROFILEDEF(.AREA.,$,{self.flat},{size[0]},{size[1]})")

    def polygon(self, *points: tuple[float, float]) -> str:
        ids = [self.step.point(*p) for p in points]
        line = self.add(f"IFCPOLYLINE(({','.join([*ids, ids[0]])}))")
        return self.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{line})")

    def minus(self, first: str, *others: str) -> str:
        for other in others:
            first = self.add(f"IFCBOOLEANRESULT(.DIFFERENCE.,{first},{other})")
        return first

    def hole(self, o: Vec, z: Vec, diameter: float, depth: float) -> str:
        x = (1, 0, 0) if abs(z[0]) < 0.5 else (0, 1, 0)
        return self.extruded(self.circle(diameter), depth, self.step.axes(o, z, x))

    def half(self, o: Vec, normal: Vec) -> str:
        """What lies beyond a plane, on the side of its normal."""
        x = (0, 1, 0) if abs(normal[1]) < 0.5 else (0, 0, 1)
        plane = self.add(f"IFCPLANE({self.step.axes(o, normal, x)})")
        return self.add(f"IFCHALFSPACESOLID({plane},.F.)")

    def element(
        self,
        body: str | None,
        kind: str = "IFCBEAM",
        tag: str = "B1",
        name: str = "",
        kind_of_body: str = "CSG",
        placement: str | None = None,
    ) -> str:
        step = self.step
        product = "$"
        if body is not None:
            shape = self.add(
                f"IFCSHAPEREPRESENTATION({step.context},'Body','{kind_of_body}',({body}))"
            )
            product = self.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        last = ",$" if step.schema != "IFC2X3" else ""
        mark = f"'{tag}'" if tag else "$"
        return self.add(
            f"{kind}('{step.guid()}',{step.owner},'BEAM',$,'{name}',{placement or self.placement},"
            f"{product},{mark}{last})"
        )

    def material(self, element: str, name: str) -> None:
        last = ",$,$" if self.step.schema != "IFC2X3" else ""
        material = self.add(f"IFCMATERIAL('{name}'{last})")
        self.add(
            f"IFCRELASSOCIATESMATERIAL('{self.step.guid()}',{self.step.owner},$,$,({element}),{material})"
        )

    def properties(self, element: str, of: str, **values: str) -> None:
        rows = [
            self.add(f"IFCPROPERTYSINGLEVALUE('{name}',$,{value},$)")
            for name, value in values.items()
        ]
        found = self.add(
            f"IFCPROPERTYSET('{self.step.guid()}',{self.step.owner},'{of}',$,({','.join(rows)}))"
        )
        self.add(
            f"IFCRELDEFINESBYPROPERTIES('{self.step.guid()}',{self.step.owner},$,$,({element}),{found})"
        )

    def assembly(self, element: str, tag: str) -> None:
        whole = self.add(
            f"IFCELEMENTASSEMBLY('{self.step.guid()}',{self.step.owner},'A',$,$,{self.placement},$,"
            f"'{tag}',.FACTORY.,.USERDEFINED.)"
        )
        self.add(
            f"IFCRELAGGREGATES('{self.step.guid()}',{self.step.owner},$,$,{whole},({element}))"
        )

    def bolt(self, o: Vec, z: Vec, diameter: float, length: float) -> str:
        solid = self.hole(o, z, diameter, length)
        shape = self.add(
            f"IFCSHAPEREPRESENTATION({self.step.context},'Body','SweptSolid',({solid}))"
        )
        product = self.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        size = self.step.length(diameter), self.step.length(length)
        return self.add(
            f"IFCMECHANICALFASTENER('{self.step.guid()}',{self.step.owner},'BOLT',$,$,"
            f"{self.placement},{product},$,{size[0]},{size[1]},.BOLT.)"
        )

    @property
    def data(self) -> bytes:
        return self.step.text().encode()
