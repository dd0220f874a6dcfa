"""Wrong programs of copers and tubes for `solid.py`: what their torch takes is not what it should.

Made of a plan that is wrong, by the classes of `coping_plans.py`, or of the text of a program.
"""

import random
import re
from collections.abc import Callable
from random import Random

from msgspec.structs import replace

from beamcam.errors import BeamcamError
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour
from beamcam.model.plan import CopeCut, CopePlan
from beamcam.model.request import Job, Request
from beamcam.planning.coping.plan import plan_coping
from benchmarks import coping_faults, coping_plans
from benchmarks.solid_cases import Case, posted, stock_of

_TURN = re.compile(r"(?m)^G0 A(-?\d+)(?: B0)?$")
_PLACE = re.compile(r"(?m)^(G1 .* A)(-?[\d.]+)( .*)$")


def of_plan(case: Case, change: Callable[[CopePlan, random.Random], CopePlan | None],
            rng: Random) -> str | None:  # fmt: skip
    """The program of a plan that is changed; None where there is nothing to change."""
    try:
        plan = plan_coping((case.part,), case.machine, None, ("all",))
        changed = change(plan, rng)
    except (BeamcamError, NotImplementedError):  # a path that falls apart beside its contour
        return None
    job = Job(Request((case.part,), case.machine, ("all",), name="JOB"), (0,))
    return None if changed is None else coping_faults.program_of(changed, job)


def kerf_side(case: Case, rng: Random) -> str | None:
    """A cut on the wrong side of its contour."""
    return of_plan(case, coping_plans.on_the_part, rng)


def cope_moved(case: Case, rng: Random) -> str | None:
    """A cope, a notch or an end 1 mm along the bar."""
    off = rng.choice((-1.0, 1.0))

    def change(cut: CopeCut) -> CopeCut:
        return replace(cut, path=tuple((x + off, y) for x, y in cut.path))

    def is_across(cut: CopeCut) -> bool:
        """Whether it goes across the bar for more than a kerf."""
        ys = [y for _, y in cut.path[cut.lead :]]
        return cut.kind != "inner" and max(ys) - min(ys) > 2 * cut.row.kerf

    def moved(plan: CopePlan, chance: random.Random) -> CopePlan | None:
        which = [k for k, cut in enumerate(plan.operations) if is_across(cut)]
        if not which:
            return None
        k = chance.choice(which)
        cuts = plan.operations
        return replace(plan, operations=(*cuts[:k], change(cuts[k]), *cuts[k + 1 :]))

    return of_plan(case, moved, rng)


def angle(case: Case, rng: Random) -> str | None:
    """The torch looks at another wall for a cut; of a tube, one place of a cut-out is elsewhere."""
    if stock_of(case.part, case.machine) == "tubes":
        inner = case.text.find("(cut-out)")
        rest = case.text.find("(", inner + 1)
        places = [] if inner < 0 else [*_PLACE.finditer(case.text, inner, rest)][4:-4]
        if not places:
            return None
        place = rng.choice(places)
        off = float(place[2]) + rng.choice((-9, 9))
        return f"{case.text[: place.start()]}{place[1]}{off:g}{place[3]}{case.text[place.end() :]}"
    turns = [*_TURN.finditer(case.text)]
    ends = [*(turn.start() for turn in turns[1:]), len(case.text)]
    stretches = [(t, end) for t, end in zip(turns, ends[: len(turns)], strict=True)
                 if "M3 " in case.text[t.end() : end]]  # fmt: skip
    if not stretches:
        return None
    turn, end = rng.choice(stretches)
    other = rng.choice([a for a in ("-90", "0", "90") if a != turn[1]])
    wrong = re.sub(rf" A{turn[1]}\b", f" A{other}", case.text[turn.start() : end])
    return f"{case.text[: turn.start()]}{wrong}{case.text[end:]}"


def elsewhere(case: Case, rng: Random) -> str | None:
    """A cut-out of a tube a quarter of a turn on."""
    return of_plan(case, coping_plans.elsewhere_round, rng)


def seam(case: Case, rng: Random) -> str | None:
    """An end of a tube that is not cut all round."""
    return of_plan(case, coping_plans.ends_before_the_seam, rng)


def missing(case: Case, rng: Random) -> str | None:
    """A hole, a slot, a cut-out or the cut of an end is not made."""
    return of_plan(case, coping_plans.left_out, rng)


def length(case: Case, rng: Random) -> str | None:
    """The part is longer or shorter behind its middle, its outlines too."""
    off = rng.choice((-1, 1)) * rng.uniform(0.6, 8.0)
    part = case.part
    if part.made is not None:
        return None

    def moved(point: Point) -> Point:
        return (point[0] + off, point[1]) if point[0] > part.length / 2 else point

    def stretched(curve: Curve) -> Curve:
        if isinstance(curve, Line):
            return Line(moved(curve.start), moved(curve.end))
        x, y = moved(curve.start)
        return curve.transformed(((1.0, 0.0, x - curve.start[0]), (0.0, 1.0, y - curve.start[1])))

    features = tuple(
        replace(f, curves=tuple(map(stretched, f.curves)))
        if isinstance(f, Contour) and f.kind == "outer"
        else f
        for f in part.features
    )
    return posted(replace(part, length=part.length + off, features=features), case.machine)
