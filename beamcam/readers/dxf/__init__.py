"""The DXF reader: every curve of model space, exact, in mm."""

from beamcam.readers.dxf.reader import looks_like, read
from beamcam.readers.dxf.rules import RULES

__all__ = ["RULES", "looks_like", "read"]
