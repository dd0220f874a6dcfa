"""Ways to make a coper's program wrong, all to be refused by the read-back.

By classes: what the planner could get wrong (the side of the kerf, a mirrored or moved contour,
sharp corners, leads in the part, a cut that is missing, made twice or ends too early, the order,
the row of the cut chart, the steps at roots), and what of a program's text (A, F, inverse time,
heights, waits, switches, blending). So many random profiles are tried, as many with skew ends, for
a torch that tilts and for one that does not, with copes near to the roots, C sections with lips of
each of these kinds, pieces that come cut, which may also be taken for a bar or for a longer piece,
tubes, round and rectangular, with narrow slots too, tubes that come cut with what is open to their
ends, and profiles that turn, C sections and pieces that come cut among them:

    python benchmarks/coping_faults.py 20
"""

import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1]))

from beamcam.emitters.gcode import head_lines
from beamcam.errors import PlanError, errors_in
from beamcam.geometry.curves import Line
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, Feature, Part
from beamcam.model.plan import CopeCut, CopePlan, left_out_kinds, manual_work_sources
from beamcam.model.request import Job, Request
from beamcam.pipeline import RefusedProgram, post
from beamcam.planning.coping import plan as planner
from beamcam.planning.turning import TURNS, alike, turned
from beamcam.posts import post_of
from benchmarks.coping_bevels import BEVEL_TEXTS, whole_of
from benchmarks.coping_plans import is_tilted, plan_faults, reordered
from benchmarks.coping_texts import TEXTS, TILT_TEXTS, TUBE_TEXTS, TURNED_TEXTS
from benchmarks.script import arguments, at_least, start
from tests.random_bevels import random_cut_out, random_end
from tests.random_boxes import random_box
from tests.random_copes import (
    CEES,
    SMALL_ROOTS,
    random_bevel,
    random_cope,
    random_lipped,
    random_mitre,
    random_prepared_web,
    random_shaped_bevel,
    random_slant,
    random_stripped,
    random_tee,
)  # fmt: skip
from tests.random_pieces import random_open
from tests.random_tubes import random_slotted, random_tube


def program_of(plan: CopePlan, job: Job) -> str:
    """The text of a plan's program."""
    post = post_of(job.machine)
    head = head_lines(job, plan, left_out_kinds(plan), sum(1 for _ in manual_work_sources(plan)))
    program = post.with_head(post.motion(plan, job.machine, "JOB"), tuple(head))
    text = post.emit(program, job)
    assert isinstance(text, str)
    return text


def faults(part: Part, machine: Machine, chance: random.Random) -> Iterator[tuple[str, str]]:
    """A wrong program of each class that the part has something for. Raises PlanError."""
    job = Job(Request((part,), machine, name="JOB"), (0,))
    plan = planner.plan_coping((part,), machine)
    right = program_of(plan, job)
    for name, of_plan in plan_faults(machine, plan.profile.code).items():
        if part.made is not None and of_plan is reordered:
            continue  # nothing is parted from a bar
        wrong = of_plan(plan, chance)
        if wrong is not None and (text := program_of(wrong, job)) != right:
            yield name, text
    coper = machine.coper
    assert coper is not None
    texts = TILT_TEXTS | BEVEL_TEXTS if coper.tilt else TEXTS
    if coper.turns == "bar":
        texts = TUBE_TEXTS if coper.unrolls(plan.profile.code) else TURNED_TEXTS
    for name, of_text in texts.items():
        lines = of_text(right.split("\n"), chance)
        if lines is not None and "\n".join(lines) != right:
            yield name, "\n".join(lines)
    if coper.turns == "bar":
        yield "over the chuck", over_the_chuck(part, machine, right)
    if part.made is not None:
        yield from piece_faults(part, machine)
        if coper.unrolls(plan.profile.code):
            yield from open_faults(plan, job, chance)
    if part.profile.code == "C":
        yield from lip_faults(part, machine, right)
    if any(cut.lower for cut in plan.operations):
        yield from square_faults(part, plan, job)
    if any(is_tilted(cut) and not cut.bevel for cut in plan.operations):
        upright = replace(machine, coper=replace(coper, tilt=0.0))
        yield "cut square", program_of(planner.plan_coping((part,), upright), job)
    if any(said.code == "plan-coping-rounded" for said in plan.remarks):
        sharp = replace(machine, coper=replace(coper, corner_radius=2.5))
        yield "sharp corners", program_of(planner.plan_coping((part,), sharp), job)


def square_faults(part: Part, plan: CopePlan, job: Job) -> Iterator[tuple[str, str]]:
    """An edge that one pass makes through all of the wall, cut square behind it and before it."""
    bare = tuple(replace(f, bevels=()) if isinstance(f, Contour) else f for f in part.features)
    square = planner.plan_coping((replace(part, features=bare),), job.machine)
    for name, first in (("bevel cut square behind", 1), ("bevel cut square before", 0)):
        for cut, _ in whole_of(plan):
            k = plan.operations.index(cut) + first
            more = tuple(c for c in square.operations if c not in plan.operations
                         and (c.face, c.kind) == (cut.face, cut.kind))  # fmt: skip
            ops = (*plan.operations[:k], *more, *plan.operations[k:])
            yield name, program_of(replace(plan, operations=ops), job)


def lip_faults(part: Part, machine: Machine, right: str) -> Iterator[tuple[str, str]]:
    """Programs for a C with shorter lips, and for one that lies end for end on them."""
    job = Job(Request((part,), machine, name="JOB"), (0,))
    shorter = replace(part, profile=replace(part.profile, lip=(part.profile.lip or 0.0) / 2))
    text = program_of(planner.plan_coping((shorter,), machine), job)
    if text != right:
        yield "shorter lips", text
    turn = next(t for t in TURNS if t.name == "turned 180 about its length")
    if not alike(turned(part, turn), part):
        try:
            plan = planner.plan_coping((turned(part, turn),), machine)
        except PlanError:
            return
        yield "turned over", program_of(plan, job)


def over_the_chuck(part: Part, machine: Machine, right: str) -> str:
    """A travel, with the torch off, to where the chuck holds the bar, or the end of a piece."""
    coper = machine.needed(machine.coper, "coper")
    held = part.length + 2 * coper.trim
    if part.made is not None:
        held = coper.trim + part.length - coper.chuck
    lines, x = right.split("\n"), held - coper.torch_width / 2 + 0.1
    k = max(k for k, line in enumerate(lines) if line.startswith("G0 X"))
    return "\n".join([*lines[: k + 1], f"G0 X{x:g}", *lines[k + 1 :]])


def random_piece(seed: int) -> Part:
    """A random profile whose ends are there: what a saw leaves of it."""
    part = (random_tee if seed % 4 == 3 else random_cope)(seed)
    holes = tuple(f for f in part.features if not isinstance(f, Contour))
    rest = tuple(f for f in part.features if isinstance(f, Contour))
    return replace(part, features=rest, made=holes)


HELD = 300.0  #: mm behind a piece that a chuck may hold


def random_held(seed: int) -> Part:
    """A random piece that comes cut, its far end long enough for a chuck and not coped."""
    make = (random_cope, random_tee, random_lipped)[seed % 3]
    part = make(seed)
    outlines = [f for f in part.features if isinstance(f, Contour) and f.kind == "outer"]
    inner = [f for f in part.features if isinstance(f, Contour) and f.kind != "outer"]
    there = [f for f in part.features if not isinstance(f, Contour)]
    kept = [one for one in (_uncoped(c, part) for c in outlines) if one is not None]
    # Half of them have their holes there, the others are to be cut.
    more, made = ([], there) if seed % 2 else (there, [])
    return replace(
        part, length=part.length + HELD, features=(*kept, *inner, *more), made=tuple(made)
    )


def _uncoped(contour: Contour, part: Part) -> Contour | None:
    """An outline whose far half goes on straight to the end of a longer part; None where it is
    notched in the middle."""
    middle, end, curves = part.length / 2, part.length + HELD, list(contour.curves)
    out = [k for k, c in enumerate(curves) if c.start[0] <= middle < c.end[0]]
    back = [k for k, c in enumerate(curves) if c.end[0] <= middle < c.start[0]]
    wide = part.profile.face_width(contour.face)
    if len(out) != 1 or len(back) != 1:
        return None
    (k,), (n,) = out, back
    if {curves[k].start[1], curves[n].end[1]} != {0.0, wide}:
        return None
    near = [*curves[n + 1 :], *curves[:k]] if n > k else curves[n + 1 : k]
    a, b = (end, curves[k].start[1]), (end, curves[n].end[1])
    ring = (Line(curves[k].start, a), Line(a, b), Line(b, curves[n].end), *near)
    return replace(contour, curves=ring)


def random_tube_piece(seed: int) -> Part:
    """A random tube, round or rectangular, whose ends and every second cut-out are there."""
    part = (random_tube if seed % 2 else random_box)(seed // 2)
    ends = [f for f in part.features if isinstance(f, Contour) and f.kind == "outer"]
    asked: list[Feature] = []
    made: list[Feature] = [*ends]
    for feature in part.features:
        if feature not in ends:
            x = (
                min(c.bbox[0] for c in feature.curves)
                if isinstance(feature, Contour)
                else feature.x
            )  # type: ignore[union-attr]  # of a hole or a slot
            (made if round((x - 150.0) / 70.0) % 2 else asked).append(feature)
    return replace(part, features=tuple(asked), made=tuple(made))


def piece_faults(part: Part, machine: Machine) -> Iterator[tuple[str, str]]:
    """Programs for other steel than the piece that comes."""
    job = Job(Request((part,), machine, name="JOB"), (0,))
    bar = replace(part, made=None)
    with suppress(PlanError):  # a header that the outlines of its bar would deny
        yield "taken for a bar", program_of(planner.plan_coping((bar,), machine), job)
    if any(c.kind == "far" for c in planner.plan_coping((part,), machine).operations):
        longer = replace(part, length=part.length + 3.0)
        try:
            plan = planner.plan_coping((longer,), machine)
        except PlanError:
            return
        yield "taken for a longer piece", program_of(plan, job)


def open_faults(plan: CopePlan, job: Job, chance: random.Random) -> Iterator[tuple[str, str]]:
    """Cuts that are open to the end of a tube, elsewhere round it, begun in the air before it or
    ended at it, and gone on along it."""
    which = [k for k, cut in enumerate(plan.operations) if cut.kind != "inner"]
    if not which:
        return
    k = chance.choice(which)
    cut = plan.operations[k]
    (x, u), (xb, ub) = cut.path[0], cut.path[-1]
    back = cut.path[:1] + tuple(reversed(cut.path[1:]))
    changed: dict[str, CopeCut] = {
        "open cut moved round": _moved(cut, 0.0, chance.choice((-0.6, 0.6))),
        "open cut in the air": replace(cut, path=((x - 9.0, u), *cut.path[1:])),
        "open cut on along the end": replace(cut, path=(*cut.path, (xb, ub + 9.0), (xb, ub - 9.0))),
        "open cut the other way round": replace(cut, path=back),
    }
    for name, wrong in changed.items():
        ops = (*plan.operations[:k], wrong, *plan.operations[k + 1 :])
        yield name, program_of(replace(plan, operations=ops), job)


def _moved(cut: CopeCut, x: float, u: float) -> CopeCut:
    return replace(cut, path=tuple((at + x, way + u) for at, way in cut.path))


def survivors(count: int, first: int = 0) -> tuple[Counter[str], list[tuple[int, str, str]], int]:
    """Wrong programs by class, those that the read-back took, and sound ones that it refused.

    They are those of so many profiles, T sections and pieces that come cut, round and rectangular
    tubes, from the `first` random one of each on.
    """
    chance = random.Random(first)
    tried: Counter[str] = Counter()
    taken: list[tuple[int, str, str]] = []
    refused = 0
    kinds: tuple[tuple[str, Callable[[int], Part]], ...] = (
        ("coper", random_cope), ("tube", random_tube), ("coper", random_piece),
        ("tube", random_box), ("coper", random_tee), ("coper-tilt", random_mitre),
        ("coper", random_mitre), ("coper-tilt", random_bevel), ("coper", random_slant),
        ("coper-tilt", random_prepared_web), ("coper-tilt", random_shaped_bevel),
        ("tube", random_cope), ("tube", random_tee),
        ("tube", random_slant), ("coper", random_lipped),
        ("coper-tilt", partial(random_mitre, sections=CEES)),
        ("coper", partial(random_mitre, sections=CEES)),
        ("coper", partial(random_slant, sections=CEES)),
        ("tube", random_lipped), ("tube", partial(random_mitre, sections=CEES)),
        ("tube", partial(random_slant, sections=CEES)), ("tube", random_held),
        ("tube", random_tube_piece), ("tube", random_open), ("tube", random_slotted),
        ("coper-tilt", random_cut_out), ("coper-tilt", random_end),
        ("coper", partial(random_cope, near=True)), ("tube", partial(random_tee, near=True)),
        ("coper", partial(random_cope, sections=CEES, near=True)),
        ("coper", random_stripped), ("tube", random_stripped),
        ("coper", partial(random_cope, sections=SMALL_ROOTS, near=True)),
    )  # fmt: skip
    for number in range(len(kinds) * first, len(kinds) * (first + count)):
        kind, make = kinds[number % len(kinds)]
        machine, part = load(f"{kind}-linuxcnc"), make(number // len(kinds))
        job = Job(Request((part,), machine, name="JOB"), (0,))
        verify = post_of(machine).verify
        try:
            post((part,), machine, "JOB")
        except PlanError:
            continue
        except RefusedProgram:  # by what it cuts, or by the list of manual work beside it
            refused += 1
        for name, text in faults(part, machine, chance):
            tried[name] += 1
            if not errors_in(verify(text, job)):
                taken.append((number, name, text))
    return tried, taken, refused


def roots_taken(count: int) -> tuple[int, list[int]]:
    """How many programs cut a root, and of which parts one was taken by a machine that has none
    cut."""
    machine = load("coper-linuxcnc")
    kept = replace(machine, coper=replace(machine.needed(machine.coper, "coper"), k_area="refuse"))
    tried, taken = 0, []
    for number in range(count):
        part = random_cope(number)
        job = Job(Request((part,), machine, name="JOB"), (0,))
        try:
            plan = planner.plan_coping((part,), machine)
        except PlanError:
            continue
        if any(cut.root for cut in plan.operations):
            tried += 1
            refuses = replace(job, request=replace(job.request, machine=kept))
            if not errors_in(post_of(kept).verify(program_of(plan, job), refuses)):
                taken.append(number)
    return tried, taken


def main() -> None:
    """Prints how many wrong programs of each class there were, and which were taken."""
    parser = arguments(__doc__)
    parser.add_argument("parts", type=at_least(1), nargs="?", default=20)
    count = parser.parse_args().parts
    tried, taken, refused = survivors(count)
    tried["root cut"], roots = roots_taken(count)
    taken += [(number, "root cut", "") for number in roots]
    for name, count in sorted(tried.items()):
        print(f"{count:5}  {name}")
    for number, name, _ in taken:
        print(f"taken: {name}, part {number}")
    print(f"{tried.total()} wrong programs, {len(taken)} taken; {refused} sound ones refused")
    sys.exit(bool(taken or refused))


if __name__ == "__main__":
    start(main)
