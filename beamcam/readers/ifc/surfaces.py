"""The surfaces that faces of the kernel's solids lie on."""

from msgspec import Struct

from beamcam.readers.ifc.space import Frame, Vec, size, unit


class Plane(Struct, frozen=True):
    """The plane of x and y of a frame."""

    frame: Frame

    def moved(self, by: Frame) -> "Plane":
        return Plane(by.times(self.frame))


class Cylinder(Struct, frozen=True):
    """A cylinder about the z of a frame."""

    frame: Frame
    radius: float

    @property
    def axis(self) -> Vec:
        """The unit vector along it."""
        return unit(self.frame.z)

    def moved(self, by: Frame) -> "Cylinder":
        """The cylinder elsewhere; its radius grows as the frame does."""
        grown = size(by.vector(self.frame.x)) / size(self.frame.x)
        return Cylinder(by.times(self.frame), self.radius * grown)


class Cone(Struct, frozen=True):
    """A cone about the z of a frame, of `radius` at its origin, its sides off z by `half_rad`."""

    frame: Frame
    radius: float
    half_rad: float

    def moved(self, by: Frame) -> "Cone":
        grown = size(by.vector(self.frame.x)) / size(self.frame.x)
        return Cone(by.times(self.frame), self.radius * grown, self.half_rad)


class Unnamed(Struct, frozen=True):
    """A surface that no member is read by, with its name."""

    kind: str

    def moved(self, _by: Frame) -> "Unnamed":
        return self


Surface = Plane | Cylinder | Cone | Unnamed
