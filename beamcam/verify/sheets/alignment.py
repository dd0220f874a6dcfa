"""Curves that run along one another, not only near one another at the places that were asked.

Places at equal distances on a line may all lie on lines that cross it at equal distances, or on the
dashes of a broken line. So a place on one of two sets of curves counts as on the other only where
that runs in the same direction, or back; and the first is asked on both sides of each place where
the other ends or bends, since nowhere else one can leave the other unseen.
"""

import numpy as np

from beamcam.geometry.array_types import Flags, Floats
from beamcam.verify.sheets.elements import Elements
from beamcam.verify.sheets.grid import Pairs
from beamcam.verify.sheets.toolpaths import Samples, Toolpaths

MAX_TURN_RAD = 0.02  #: between lines and arcs that run along one another, of any length
SMOOTH_RAD = 0.26  #: from one way to the next, where they do not bend
NEAR_BEND = 4.0  #: slacks from an end or a bend, within which any direction is right
ASIDE = 8.0  #: slacks from an end or a bend, where the other curve is asked


def aligned(
    own: Toolpaths, samples: Samples, other: Toolpaths, pairs: Pairs, slack: float
) -> Flags:
    """The pairs of a sample of `own` and an element of `other` in whose direction that runs."""
    element, share, _ = samples
    ahead = own.elements.directions(element, share)[pairs.point]
    length = other.elements.length[pairs.element]
    at = np.divide(pairs.along, length, out=np.zeros(len(length)), where=length > 0.0)
    there = other.elements.directions(pairs.element, at)
    across = np.abs(ahead[:, 0] * there[:, 1] - ahead[:, 1] * there[:, 0])
    found: Flags = across <= np.sin(MAX_TURN_RAD)
    asked = np.flatnonzero(~found)
    if len(asked):
        pairs = pairs.kept(asked)
        most = (
            _most_turns(own, slack)[element[pairs.point]] + _most_turns(other, slack)[pairs.element]
        )
        found[asked] = across[asked] <= np.sin(np.minimum(MAX_TURN_RAD + most, np.pi / 2))
        found[asked] |= _near_bend(other, pairs, slack)
    return found


def _most_turns(toolpaths: Toolpaths, slack: float) -> Floats:
    """Angles in rad by which curves within the slack of elements may differ from their directions.

    A chord of length L, at its middle within the slack s of an arc on one side and at its ends on
    the other, is 8 s / L off the direction of that at its ends; an arc of radius r is
    2 sqrt(s / r) off that of such a chord. A chord that the next one leaves at the angle b is one
    of an arc of radius L / b; of short chords, such as those between whole steps, some may go on
    straight, so that the next bend counts.
    """
    elements = toolpaths.elements
    turns = _turns(elements, slack)
    bend = _most_near(turns, elements.length, NEAR_BEND * slack)
    radius = elements.arcs[elements.is_arc, 2]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # absurdly short or long
        share = slack / elements.length
        found: Floats = np.fmin(8.0 * share, bend / 2 + 2.0 * np.sqrt(bend * share))
        found[elements.is_arc] += 2.0 * np.sqrt(slack / radius)
    return found


def _most_near(turns: Floats, lengths: Floats, reach: float) -> Floats:
    """The greatest turn at an element or no farther from it than `reach`, for each."""
    places = np.append(0.0, np.cumsum(lengths))
    first = np.searchsorted(places, places[:-1] - reach)
    behind = np.searchsorted(places, places[1:] + reach, "right")
    windows = np.column_stack((first, behind)).ravel()
    found: Floats = np.maximum.reduceat(np.append(turns, 0.0), windows)[::2]
    return found


def beside_bends(own: Toolpaths, other: Toolpaths, slack: float) -> Samples:
    """The places of `own` on both sides of where a way of `other` ends or bends beside it.

    Where a way of `own` has no such place inside, the other runs along all of it or nowhere.
    """
    begins, ends, meets = _bends(other, slack)
    places = np.concatenate((other.starts[begins], other.ends[ends & ~meets]))
    pairs = own.near(places, slack)
    way = own.owner[pairs.element]
    at = own.at(pairs.element, pairs.along) - own.begins[way]
    aside = ASIDE * slack
    inside = np.flatnonzero((at > aside) & (at < own.lengths[way] - aside))
    way, at = np.tile(way[inside], 2), at[inside]
    return own.samples_at(way, np.concatenate((at - aside, at + aside)))


def _near_bend(toolpaths: Toolpaths, pairs: Pairs, slack: float) -> Flags:
    """Pairs whose place on the element is near where its way ends or bends."""
    begins, ends, _ = _bends(toolpaths, slack)
    way = toolpaths.owner[pairs.element]
    at, reach = toolpaths.at(pairs.element, pairs.along) - toolpaths.begins[way], NEAR_BEND * slack
    found: Flags = begins[way] & (at <= reach)
    return found | (ends[way] & (at >= toolpaths.lengths[way] - reach))


def _bends(toolpaths: Toolpaths, slack: float) -> tuple[Flags, Flags, Flags]:
    """The ways that begin at a bend, those that end at one, and those that end at the next one."""
    turns, every = _turns(toolpaths.elements, slack), np.arange(toolpaths.count)
    before, behind = turns[toolpaths.first(every)], turns[toolpaths.last(every) + 1]
    return before > SMOOTH_RAD, behind > SMOOTH_RAD, np.isfinite(behind)


def _turns(elements: Elements, slack: float) -> Floats:
    """Angles in rad before each element and behind the last, (n + 1,).

    Infinite where nothing goes on, or only what does not come next.
    """
    every = np.arange(len(elements))
    ahead = elements.directions(every, np.zeros(len(every)))
    behind = elements.directions(every, np.ones(len(every)))
    meets = np.hypot(*(elements.end[:-1] - elements.start[1:]).T) <= slack
    turns = np.arccos(np.clip(np.sum(behind[:-1] * ahead[1:], axis=1), -1.0, 1.0))
    found = np.full(len(every) + 1, np.inf)
    found[1:-1] = np.where(meets, turns, np.inf)
    return found
