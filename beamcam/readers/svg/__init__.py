"""The SVG reader: every stroked shape, exact, in mm from the lower left corner of the page."""

from beamcam.readers.svg.reader import looks_like, read
from beamcam.readers.svg.rules import RULES

__all__ = ["RULES", "looks_like", "read"]
