"""T sections whose header stands on end: the stem's height in line 10, the flange's width in 11.

DSTV, 7th edition, page 7: the flange of a T lies along Y, so that line 10, the height, is how wide
it is, and its stem stands along Z, so that line 11 is how high that is.
"""

import re

from beamcam.geometry.plane import join_boxes
from beamcam.model.part import Contour, Part, Profile
from beamcam.model.section import measures_of
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.blocks import Log

DRAWN = 1.0  #: mm between an outline and its figure in the header
HALF = 3.0  #: mm between half a beam and a T: its cut takes some
NOMINAL = 0.1  #: share that the stem of a WT is off its name
INCHES = 50.0  #: nominal heights of fewer are inches: WT22 is the highest, WT100 the lowest in mm
_WT = re.compile(r"\s*(?:WT|MT|ST)\s*([0-9]+(?:\.[0-9]+)?)\s*[xX*]")
_HALVED = re.compile(r"\s*(?:1/2\s*|½\s*)(\S.*?)\s*|\s*(\S.*?)\s*/\s*2\s*")


def upright(data: bytes, part: Part, header: list[int], log: Log) -> bytes | None:
    """A file whose header has the sizes of its T as the outlines are, where they stand on end.

    None of any other file. Where no outline shows it but the name does, that is told, and the
    header counts. `header` are the lines of its values.
    """
    profile = part.profile
    high, wide = profile.height, profile.width
    if profile.code != "T" or abs(high - wide) <= DRAWN:
        return None
    values = {"name": profile.name, "height": high, "width": wide}
    flange, stem = _drawn(part, "v"), _drawn(part, "ou")
    fits = [(size, *pair) for size, *pair in ((flange, high, wide), (stem, wide, high)) if size]
    size, right, wrong = fits[0] if fits else (high, high, wide)
    rows = data.splitlines(keepends=True)
    if abs(size - wrong) <= DRAWN and abs(size - wrong) < abs(size - right):
        log.add(rules.TEE_OUTLINE, header[9], **values)
        for k in (9, 11):  # height and width, thicknesses of flange and web
            a, b = header[k] - 1, header[k + 1] - 1
            rows[a], rows[b] = rows[b], rows[a]
        return b"".join(rows)
    if not fits and _named_on_end(profile):
        log.add(rules.TEE_NAME, header[9], **values)
    return None


def _drawn(part: Part, faces: str) -> float:
    """How far the outlines on some faces reach across; 0 without any."""
    boxes = [
        curve.bbox
        for c in part.features if isinstance(c, Contour) and c.kind == "outer" and c.face in faces
        for curve in c.curves
    ]  # fmt: skip
    box = join_boxes(boxes)
    return 0.0 if box is None else box[3]


def _named_on_end(profile: Profile) -> bool:
    """Whether the name has a stem as high as line 10, and not as line 11."""
    if match := _WT.match(profile.name):
        nominal = float(match[1]) * (25.4 if float(match[1]) < INCHES else 1.0)
        first, second = (abs(size - nominal) for size in (profile.height, profile.width))
        return first <= NOMINAL * nominal < second
    match = _HALVED.fullmatch(profile.name)
    known = measures_of(match[1] or match[2]) if match else None
    if known is None or known[0] != "I":
        return False
    stem, flange = known[1][0] / 2, known[1][1]
    on_end = max(abs(profile.height - stem), abs(profile.width - flange))
    as_is = max(abs(profile.width - stem), abs(profile.height - flange))
    return on_end <= HALF < as_is
