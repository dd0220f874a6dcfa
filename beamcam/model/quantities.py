"""Numbers and points of a part's JSON form, each with the limits of its kind."""

from typing import Annotated

from msgspec import Meta

from beamcam.geometry.plane import MAX_COORDINATE

#: A part reaches from one end of all coordinates to the other at most.
MAX_NUMBER = 10 * MAX_COORDINATE
ALONG_DEG = 90.0  #: of an end cut that would run along the part, and so is none

Number = Annotated[float, Meta(ge=-MAX_NUMBER, le=MAX_NUMBER)]
Positive = Annotated[float, Meta(gt=0, le=MAX_NUMBER)]
NotNegative = Annotated[float, Meta(ge=0, le=MAX_NUMBER)]
Whole = Annotated[int, Meta(ge=-int(MAX_NUMBER), le=int(MAX_NUMBER))]
EndAngle = Annotated[float, Meta(gt=-ALONG_DEG, lt=ALONG_DEG)]
Sweep = Annotated[float, Meta(ge=-360, le=360)]
Point = tuple[Number, Number]
Vector = tuple[Number, Number, Number]
Points = Annotated[tuple[Point, ...], Meta(min_length=2)]
Polygon = Annotated[tuple[Point, ...], Meta(min_length=3)]
Numbers = tuple[Number, ...]
