"""What the blocks of a file give the part, while they are read."""

from msgspec import Struct, field

from beamcam.model.part import Feature, Plane, SectionPoint
from beamcam.readers.dstv.contours import Rows


class Content(Struct):
    """What the blocks of a file give the part."""

    features: list[Feature | Rows] = field(default_factory=list)
    planes: list[Plane] = field(default_factory=list)
    section: list[SectionPoint] = field(default_factory=list)
    info: list[tuple[str, str]] = field(default_factory=list)
    tolerance: tuple[float, float] | None = None
    contours: list[Rows] = field(default_factory=list)
    plane_names: dict[str, str] = field(default_factory=dict)  #: by digit, the last plane's name
