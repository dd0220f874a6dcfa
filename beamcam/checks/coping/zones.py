"""Where the machine file keeps a torch from: root, other places than the seam, supports, chuck."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from beamcam.checks.coping import rules
from beamcam.checks.coping.fillets import beside_web
from beamcam.checks.coping.section import CoperSection, TubeSection
from beamcam.checks.coping.strokes import TipMove, TorchStroke
from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import Coper
from beamcam.model.part import Part

ALL_ROUND = 1e-3  #: mm that a stroke once round may lack


def root_faults(
    strokes: Sequence[TorchStroke], section: CoperSection, coper: Coper, name: str
) -> Iterator[Diagnostic]:
    """Strokes through a root on a machine whose file has none cut."""
    for stroke in strokes if coper.k_area == "refuse" else ():
        ys = [y for _, y in stroke.points]
        crosses = min(ys) < section.front and max(ys) > section.back
        if stroke.face != "v" and (crosses or beside_web(stroke, section)):
            yield rules.ZONE.at(
                Source(name, stroke.line), found=f"a cut through the root on face {stroke.face}",
                expected='none, coper.k_area is "refuse"',
            )  # fmt: skip


def seam_faults(
    strokes: Sequence[TorchStroke], section: TubeSection, coper: Coper, slack: float, name: str
) -> Iterator[Diagnostic]:
    """Strokes once round a tube that begin away from its seam."""
    turn = section.turn
    seam = coper.seam * turn / 360.0
    for stroke in strokes:
        us = [u for _, u in stroke.points]
        off = abs((us[0] - seam + turn / 2) % turn - turn / 2)
        if abs(us[-1] - us[0]) >= turn - ALL_ROUND and off > slack:
            yield rules.ZONE.at(
                Source(name, stroke.line), found=f"an end begun {off:.1f} mm off the seam",
                expected=f"it at {coper.seam:g} of 360 round the tube, by coper.seam",
            )  # fmt: skip


def support_faults(strokes: Sequence[TorchStroke], coper: Coper, name: str) -> Iterator[Diagnostic]:
    """Strokes that come to a support of the bar, half the torch's width included."""
    half, start = coper.torch_width / 2, coper.trim
    for stroke in strokes:
        for zone in coper.supports:
            low, high = zone.min - half - start, zone.max + half - start
            if any(low < max(a, b) and min(a, b) < high
                   for (a, _), (b, _) in pairwise(stroke.points)):  # fmt: skip
                yield rules.ZONE.at(
                    Source(name, stroke.line), found=f"a cut on face {stroke.face}",
                    expected=f"none over the support from X {zone.min:g} to {zone.max:g}",
                )  # fmt: skip


def chuck_faults(
    ways: Sequence[TipMove], part: Part, coper: Coper, name: str
) -> Iterator[Diagnostic]:
    """The first place of the torch over the stretch that the chuck holds: of a bar what is behind
    the part and the trims, of a piece that comes cut its own far end."""
    held = part.length + 2 * coper.trim
    if part.made is not None:
        held = coper.trim + part.length - coper.chuck
    free = held - coper.torch_width / 2
    for way in ways:
        if (x := max(way.start[0], way.end[0])) > free:
            yield rules.ZONE.at(
                Source(name, way.line), found=f"the torch at X {x:.1f}, over the chuck",
                expected=f"X {free:g} at most, as the bar is held behind it",
            )  # fmt: skip
            return
