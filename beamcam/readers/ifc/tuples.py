"""Points, directions and axis placements of a file, all at once.

    #1=IFCCARTESIANPOINT((0.,0.,2.5));           (0.0, 0.0, 2.5)
    #2=IFCDIRECTION((0.,0.,1.));                 (0.0, 0.0, 1.0)
    #3=IFCAXIS2PLACEMENT3D(#1,#2,$);             ((0.0, 0.0, 2.5), (0.0, 0.0, 1.0), None)

They are most of a file's records, are nothing but numbers, and read together they cost a tenth of
what they cost one by one. So they stand for themselves among the values of others.
"""

from collections.abc import Collection
from typing import Any

import numpy as np
from msgspec import DecodeError
from msgspec.json import Decoder
from numpy.typing import NDArray

from beamcam.readers.ifc.characters import Truths
from beamcam.readers.ifc.step import MISSING, NONE_GIVEN, Records

KINDS = ("IFCCARTESIANPOINT", "IFCDIRECTION", "IFCAXIS2PLACEMENT2D", "IFCAXIS2PLACEMENT3D")

Objects = NDArray[np.object_]  #: one for each record, or for each of some

_NUMBERS = Decoder(list[tuple[float, ...]])


def tuples(of: Records) -> tuple[Objects, Truths]:
    """The points, directions and axis placements by the indices of their records; which these are.

    A kind of which some are written in an unusual way is left out; it is read like any other.
    """
    found: Objects = np.full(len(of), None)
    known_at: Truths = np.zeros(len(of), bool)
    for kind in KINDS[:2]:
        indices = of.of(kind)
        texts = of.inners(indices).texts()
        # Most directions are along an axis.
        distinct = dict.fromkeys(texts)
        known = dict(zip(distinct, _decoded(distinct), strict=False))
        if len(known) == len(distinct):
            found[indices] = objects(list(map(known.__getitem__, texts)))
            known_at[indices] = True
    for kind, count in zip(KINDS[2:], (2, 3), strict=True):
        indices = of.of(kind)
        columns = of.references(indices, count)
        if columns is None:
            continue
        given = [column != NONE_GIVEN for column in columns]
        to = [column[there] for column, there in zip(columns, given, strict=True)]
        if any((column == MISSING).any() or not known_at[column].all() for column in to):
            continue  # a reference to nothing, or to another kind
        sides = [np.full(len(indices), None) for _ in columns]
        for side, there, column in zip(sides, given, to, strict=True):
            side[there] = found[column]
        found[indices] = objects(list(zip(*(side.tolist() for side in sides), strict=True)))
        known_at[indices] = True
    return found, known_at


def objects(of: list[Any]) -> Objects:
    """An array of them, also where they are sequences themselves."""
    return np.fromiter(of, object, len(of))


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
