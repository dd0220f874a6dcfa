"""Points, directions and axis placements of a file, all at once.

    #1=IFCCARTESIANPOINT((0.,0.,2.5));           (0.0, 0.0, 2.5)
    #2=IFCDIRECTION((0.,0.,1.));                 (0.0, 0.0, 1.0)
    #3=IFCAXIS2PLACEMENT3D(#1,#2,$);             ((0.0, 0.0, 2.5), (0.0, 0.0, 1.0), None)

They are most of a file's records, are nothing but numbers, and read together they cost a tenth of
what they cost one by one. So they stand for themselves among the values of others.
"""

from collections.abc import Collection
from typing import Any

from msgspec import DecodeError
from msgspec.json import Decoder

from beamcam.readers.ifc.step import NONE_GIVEN, Records

KINDS = ("IFCCARTESIANPOINT", "IFCDIRECTION", "IFCAXIS2PLACEMENT2D", "IFCAXIS2PLACEMENT3D")

_NUMBERS = Decoder(list[tuple[float, ...]])


def tuples(of: Records) -> dict[int, Any]:
    """The points, directions and axis placements by the indices of their records.

    A kind of which some are written in an unusual way is left out; it is read like any other.
    """
    found: dict[int, Any] = {NONE_GIVEN: None}
    for kind in KINDS[:2]:
        indices = of.of(kind)
        texts = of.inners(indices)
        # Most directions are along an axis.
        distinct = dict.fromkeys(texts)
        known = dict(zip(distinct, _decoded(distinct), strict=False))
        if len(known) == len(distinct):
            found.update(zip(indices.tolist(), map(known.__getitem__, texts), strict=True))
    for kind, count in zip(KINDS[2:], (2, 3), strict=True):
        indices = of.of(kind)
        columns = of.references(indices, count)
        try:
            sides = [list(map(found.__getitem__, column)) for column in columns or ()]
        except KeyError:  # a reference to another kind, or to nothing
            continue
        if sides:
            found.update(zip(indices.tolist(), zip(*sides, strict=True), strict=True))
    del found[NONE_GIVEN]
    return found


def _decoded(texts: Collection[str]) -> list[tuple[float, ...]]:
    """The numbers of each text, `(0.,0.,1.)`; nothing if one is not written as numbers are.

    Read as JSON, which is the fastest way there is, and wants a digit behind the point.
    """
    joined = ",".join(texts).replace("(", "[").replace(")", "]")
    joined = joined.replace(".,", ".0,").replace(".]", ".0]").replace(".E", ".0E")
    try:
        return _NUMBERS.decode(f"[{joined}]")
    except DecodeError:
        return []
