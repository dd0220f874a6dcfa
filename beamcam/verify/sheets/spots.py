"""Spots: centres for the drill, burnt by a torch that stands, each once and before anything is cut.

A controller wants a move between the words that start and stop its tool: it is no longer than
`LONGEST`.
"""

from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.strokes import Strokes

LONGEST = 0.1  #: mm


def spot_faults(
    strokes: Strokes, need: Need, shift: tuple[float, float], tolerance: float, name: str
) -> Iterator[Diagnostic]:
    """Spots that are missing, made twice or elsewhere, moved, or made after a cut."""
    first_cut = min((s.line for s in strokes.each if s.process == "cut"), default=None)
    places = np.array(list(need.spots)).reshape(-1, 2) + np.array(shift)
    done = [0] * len(places)
    for stroke in strokes.each:
        if stroke.process != "spot":
            continue
        at, end = strokes.moves.start[stroke.first], strokes.moves.end[stroke.first : stroke.last]
        source = Source(name, stroke.line)
        values = {"x": f"{at[0]:.3f}", "y": f"{at[1]:.3f}"}
        near = np.flatnonzero(np.hypot(*(places - at).T) <= tolerance)
        for k in near.tolist():
            done[k] += 1
        reach = float(np.hypot(*(end - at).T).max())
        found = ""
        if not len(near):
            found, expected = "a spot", "none there"
        elif reach > LONGEST:
            found, expected = f"a torch that moves {reach:.3f} mm as it spots", "it standing"
        elif any(done[k] > 1 for k in near.tolist()):
            found, expected = "a second spot", "one there"
        elif first_cut is not None and stroke.line > first_cut:
            found, expected = "a spot behind a cut", "all of them before"
        if found:
            yield rules.SPOT.at(source, found=found, expected=expected, **values)
    for (x, y), feature, count in zip(
        places.tolist(), need.spots.values(), done, strict=True
    ):  # fmt: skip
        if not count:
            expected = f"the centre of {need.sources[feature]}"
            yield rules.SPOT.at(
                Source(name), found="no spot", x=f"{x:.3f}", y=f"{y:.3f}", expected=expected
            )


def without_spots(strokes: Strokes) -> Strokes:
    """The strokes that follow something, with their own moves alone."""
    kept = [s for s in strokes.each if s.process != "spot"]
    if len(kept) == len(strokes.each):
        return strokes
    spans = [np.arange(s.first, s.last) for s in kept]
    lasts = np.cumsum([len(span) for span in spans]).tolist()
    each = [
        replace(s, first=last - len(span), last=last)
        for s, span, last in zip(kept, spans, lasts, strict=True)
    ]
    return Strokes(each, strokes.moves.take(np.concatenate([np.zeros(0, dtype=np.int64), *spans])))
