"""Position of a comment in a part: the values of `Comment.before`, and their order.

An anchor names what the comment stands before:

    start                 the line ST
    header:9              header line 9
    feature:4             the row of feature 4, or the first of its rows
    feature:4:2           row 2 of feature 4, counted from 0, notch rows included
    plane:0, plane:0:1    the rows of plane 0
    section:3             row 3 of the cross-section
    tolerance             the tolerance
    info:2                line 2 of the information block
    end, after-end        the end of the file, and what follows it

`block:` before any of the names of features and the like stands before the code of the block that
begins there. Names count features, planes and rows from 0 in the order of the part.
"""

from collections.abc import Sequence

from beamcam.model.part import Feature, Plane

AnchorKey = tuple[int, ...]

_REGIONS = {"start": 0, "header": 1, "section": 2, "tolerance": 3, "info": 5, "end": 6}


def plane_positions(planes: Sequence[Plane], features: Sequence[Feature]) -> list[int]:
    """For each plane the index of the feature that it is written before, as early as can be.

    A plane whose number was used before ("E1#2") comes behind the last feature of the one before
    it, and no plane comes before one that precedes it in `planes`.
    """
    last_use = {getattr(feature, "face", ""): i for i, feature in enumerate(features)}
    positions: list[int] = []
    latest: dict[str, str] = {}
    position = 0
    for plane in planes:
        number = plane.name.split("#")[0]
        if number in latest:
            position = max(position, last_use.get(latest[number], -1) + 1)
        latest[number] = plane.name
        positions.append(position)
    return positions


def anchor_key(anchor: str, positions: Sequence[int]) -> AnchorKey:
    """A key that sorts anchors as the writer meets them. Raises ValueError for an unknown one.

    `positions` is that of `plane_positions`.
    """
    words = anchor.split(":")
    inside = 1
    if words[0] == "block":
        inside, words = 0, words[1:]
    try:
        name, places = words[0], [int(word) for word in words[1:]]
        if name == "after-end" and not places:
            return (7,)
        if name == "plane":
            index, row = ([*places, 0])[:2]
            return (4, positions[index], 0, index, inside, row)
        if name == "feature":
            index, row = ([*places, 0])[:2]
            return (4, index, 1, 0, inside, row)
        place = places[0] if places else 0
        return (_REGIONS[name], place, inside)
    except (IndexError, KeyError, ValueError):
        raise ValueError(f"unknown place {anchor!r} of a comment") from None
