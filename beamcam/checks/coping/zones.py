"""Where the machine file keeps a torch from: root, other places than the seam, supports, chuck."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from beamcam.checks.coping import rules
from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.fillets import beside_web
from beamcam.checks.coping.section import CoperSection, TubeSection
from beamcam.checks.coping.strokes import TipMove, TorchStroke
from beamcam.errors import Diagnostic

ALL_ROUND = 1e-3  #: mm that a stroke once round may be short


def root_faults(
    strokes: Sequence[TorchStroke], section: CoperSection, job: CoperJob
) -> Iterator[Diagnostic]:
    """Strokes through a root on a machine whose file has none cut."""
    for stroke in strokes if job.coper.k_area == "refuse" else ():
        least, most = stroke.across
        crosses = least < section.front and most > section.back
        if stroke.face != "v" and (crosses or beside_web(stroke, section)):
            yield rules.ZONE.at(
                job.at(stroke.line), found=f"a cut through the root on face {stroke.face}",
                expected='none, coper.k_area is "refuse"',
            )  # fmt: skip


def seam_faults(
    strokes: Sequence[TorchStroke], section: TubeSection, slack: float, job: CoperJob
) -> Iterator[Diagnostic]:
    """Strokes once round a tube that begin away from its seam."""
    turn = section.turn
    seam = job.coper.seam * turn / 360.0
    for stroke in strokes:
        us = [u for _, u in stroke.points]
        off = abs((us[0] - seam + turn / 2) % turn - turn / 2)
        if abs(us[-1] - us[0]) >= turn - ALL_ROUND and off > slack:
            yield rules.ZONE.at(
                job.at(stroke.line), found=f"an end begun {off:.1f} mm off the seam",
                expected=f"it at {job.coper.seam:g} of 360 round the tube, by coper.seam",
            )  # fmt: skip


def support_faults(strokes: Sequence[TorchStroke], job: CoperJob) -> Iterator[Diagnostic]:
    """Strokes that come to a support of the bar, half the torch's width included."""
    half, start = job.coper.torch_width / 2, job.coper.trim
    for stroke in strokes:
        for zone in job.coper.supports:
            low, high = zone.min - half - start, zone.max + half - start
            if any(low < max(a, b) and min(a, b) < high
                   for (a, _), (b, _) in pairwise(stroke.points)):  # fmt: skip
                yield rules.ZONE.at(
                    job.at(stroke.line), found=f"a cut on face {stroke.face}",
                    expected=f"none over the support from X {zone.min:g} to {zone.max:g}",
                )  # fmt: skip


def chuck_faults(ways: Sequence[TipMove], job: CoperJob) -> Iterator[Diagnostic]:
    """The first place of the torch over the stretch that the chuck holds: of a bar what is behind
    the part and the trims, of a piece that comes cut its own far end."""
    part, coper = job.part, job.coper
    held = part.length + 2 * coper.trim
    if part.made is not None:
        held = coper.trim + part.length - coper.chuck
    free = held - coper.torch_width / 2
    for way in ways:
        if (x := max(way.start[0], way.end[0])) > free:
            yield rules.ZONE.at(
                job.at(way.line), found=f"the torch at X {x:.1f}, over the chuck",
                expected=f"X {free:g} at most, as the bar is held behind it",
            )  # fmt: skip
            return
