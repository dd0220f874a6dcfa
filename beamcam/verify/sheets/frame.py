"""The frame of a job, compared with the program of the job: round all of its work, the tool off.

A laser in laser mode may be on, at the power of frames and no other.
"""

import numpy as np

from beamcam.controllers import table_run
from beamcam.controllers.events import Switch
from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.verify.sheets import rules

SAID, SAID_LOW = "FRAME OF THE JOB, THE TOOL OFF", "FRAME OF THE JOB, AT LOW POWER"
#: M words of a frame: the end, the tool off, coolant and overrides.
HARMLESS = frozenset({2, 30, 5, 9, 48, 49, 52, 53})
FASTEST = 1.001  #: by the feed of frames


def said_of(torch: Torch) -> str:
    """What a frame says of itself."""
    return SAID_LOW if torch.frame_power else SAID


def frame_faults(
    text: str, whole: str, machine: Machine, name: str = "program"
) -> tuple[Diagnostic, ...]:
    """All faults of the frame of a whole program."""
    torch = machine.needed(machine.torch, "torch")
    done, said = table_run(text, machine, name)
    job, _ = table_run(whole, machine, name)
    found = list(said)
    for _, event in done.others:
        if isinstance(event, Switch) and not _is_harmless(event, torch):
            low = f", or the tool at {torch.frame_power:g}" if torch.frame_power else ""
            wrong, right = f"the word {event}", f"no tool switched on{low}"
            found.append(rules.FRAME.at(Source(name, event.line), found=wrong, expected=right))
    lit = any(isinstance(e, Switch) and e.number in (3, 4) for _, e in done.others)
    if torch.frame_power and not lit:
        expected = f"it at a power of {torch.frame_power:g}"
        found.append(rules.FRAME.at(Source(name), found="the laser off", expected=expected))
    if errors_in(found):
        return tuple(found)
    around, frame = _box(job.moves), _box(done.moves)
    slow = done.moves.take(np.flatnonzero(~done.moves.rapid))
    source = Source(name)
    shown = " to ".join(f"X {x:.3f} Y {y:.3f}" for x, y in (around[:2], around[2:]))
    if not len(slow) or np.abs(frame - around).max() > torch.tolerance:
        got = " to ".join(f"X {x:.3f} Y {y:.3f}" for x, y in (frame[:2], frame[2:]))
        found.append(rules.FRAME.at(source, found=f"a frame from {got}", expected=shown))
        return tuple(found)
    x0, y0, x1, y1 = around.tolist()
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
    passed = np.concatenate((slow.start[:1], slow.end))
    if slow.is_arc.any() or len(passed) != 5 or np.abs(passed - corners).max() > torch.tolerance:
        expected = "the four corners of the work, one after the other"
        found.append(rules.FRAME.at(source, found="another way", expected=expected))
    elif float(slow.feed_mm_min.max()) > FASTEST * torch.frame_mm_min:
        fed = f"a feed of {float(slow.feed_mm_min.max()):g} mm/min"
        found.append(rules.FRAME.at(source, found=fed, expected=f"{torch.frame_mm_min:g}"))
    if (said_of_it := said_of(torch)) not in text:
        found.append(rules.FRAME.at(source, found="no word of what it is", expected=said_of_it))
    return tuple(found)


def _is_harmless(event: Switch, torch: Torch) -> bool:
    """Whether a word starts no tool, or a laser at the power of frames."""
    if event.number in HARMLESS or event.does == "none":
        return True
    low = event.words.get("S") == torch.frame_power
    return bool(torch.frame_power) and event.number in (3, 4) and low


def _box(moves: Moves) -> Floats:
    """The box around the moves that are no traverses: least X and Y, greatest X and Y."""
    slow = moves.take(np.flatnonzero(~moves.rapid))
    if not len(slow):
        return np.full(4, np.nan)
    boxes = [
        Arc((x, y), r, a, s).bbox
        for (x, y, r, a, s), is_arc in zip(slow.arcs.tolist(), slow.is_arc.tolist(), strict=True)
        if is_arc
    ]
    boxes += [curve.bbox for curve in slow.curves.values()]
    places = np.concatenate((slow.start, slow.end))
    boxes.append((*places.min(axis=0).tolist(), *places.max(axis=0).tolist()))
    every = np.array(boxes)
    return np.concatenate((every[:, :2].min(axis=0), every[:, 2:].max(axis=0)))
