"""Ways to make cuts of lips and through roots wrong."""

import random

from msgspec.structs import replace

from beamcam.machine import Machine
from beamcam.model.plan import CopeCut, CopePlan
from benchmarks.coping_bevels import OfPlan, changed


def lip_left_out(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A flange whose cut goes on over its lip, which only that of the flange cuts."""
    which = [cut for cut in plan.operations if cut.lip]
    if not which:
        return None
    lip = chance.choice(which)
    rest = tuple(cut for cut in plan.operations if cut is not lip)

    def change(cut: CopeCut) -> CopeCut:
        beyond = [(x, max(y, -2.0)) for x, y in lip.path if y < cut.path[1][1]]
        off = cut.path[1][0] - lip.path[1][0]
        return replace(cut, path=(*((x + off, y) for x, y in beyond[::-1]), *cut.path[1:]), lead=1)

    return changed(
        replace(plan, operations=rest), chance, change,
        lambda cut: not cut.lip and (cut.face, cut.kind) == (lip.face, lip.kind),
    )  # fmt: skip


def lip_too_shallow(machine: Machine) -> OfPlan:
    """A lip cut with the row of its flange, or of any that is not as deep."""

    def of_plan(plan: CopePlan, chance: random.Random) -> CopePlan | None:
        coper = machine.needed(machine.coper, "coper")

        def change(cut: CopeCut) -> CopeCut:
            row = chance.choice([row for row in coper.rows if row.up_to < cut.thickness])
            nearer = (cut.row.kerf - row.kerf) / 2
            nearer *= -1.0 if cut.path[0][0] > cut.path[1][0] else 1.0
            path = tuple((x + nearer, max(y, -2.0)) for x, y in cut.path)
            return replace(cut, row=row, path=path)

        return changed(plan, chance, change, lambda cut: cut.lip)

    return of_plan


def along_the_lip(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut of a lip that goes on along it, in what is scrap."""

    def change(cut: CopeCut) -> CopeCut | None:
        x, away = cut.path[-1][0], cut.path[0][0] - cut.path[1][0]
        return replace(cut, path=(*cut.path[:-1], (x, 1.0), (x + 2.5 * away, 1.0)))

    return changed(plan, chance, change, lambda cut: cut.lip and cut.kind != "notch")


def _has_step(plan: CopePlan) -> bool:
    return any(said.code == "plan-coping-step" for said in plan.remarks)


def _flange_step(plan: CopePlan, chance: random.Random, by: float | None) -> CopePlan | None:
    """A square cut of a flange whose step at the root is moved along the bar, or left out."""

    def off(cut: CopeCut) -> list[float]:
        return [x - cut.path[cut.lead][0] for x, _ in cut.path]

    def change(cut: CopeCut) -> CopeCut:
        step = max(off(cut)[cut.lead :], key=abs)
        moved = chance.choice((-1.0, 1.0)) * by if by is not None else -step
        return replace(cut, path=tuple(
            (x + (moved if k > cut.lead and abs(far) > abs(step) / 2 else 0.0), y)
            for k, ((x, y), far) in enumerate(zip(cut.path, off(cut), strict=True))
        ))  # fmt: skip

    return changed(
        plan, chance, change,
        lambda cut: cut.root and _has_step(plan) and not cut.b_deg and abs(off(cut)[-1]) < 0.01
        and max(map(abs, off(cut)[cut.lead :])) > 0.4,
    )  # fmt: skip


def _web_step(plan: CopePlan, chance: random.Random, along: float, across: float) -> (
    CopePlan | None):  # fmt: skip
    """A cut of a web whose end in a root is moved along the bar, or the round before it across."""

    def change(cut: CopeCut) -> CopeCut:
        end, sign = len(cut.path) - 2, chance.choice((-1.0, 1.0))
        return replace(cut, path=tuple(
            (x + (sign * along if k >= end else 0.0), y + (sign * across if k < end and
             abs(y - cut.path[-1][1]) < 6.0 and abs(x - cut.path[-1][0]) < 6.0 else 0.0))
            for k, (x, y) in enumerate(cut.path)
        ))  # fmt: skip

    def fits(cut: CopeCut) -> bool:
        (xa, ya), (xb, yb), (xc, _) = cut.path[-2], cut.path[-1], cut.path[-3]
        is_step = abs(xa - xb) < 1e-3 and abs(ya - yb) < 6.0 and 0.05 < abs(xc - xa) < 3.0
        return cut.face == "v" and not cut.bevel and _has_step(plan) and is_step

    return changed(plan, chance, change, fits)


#: Ways to make the steps of cuts at a root wrong.
STEPS: dict[str, OfPlan] = {
    "step moved": lambda p, c: _flange_step(p, c, 0.6),
    "step left out": lambda p, c: _flange_step(p, c, None),
    "step of the web moved": lambda p, c: _web_step(p, c, 0.6, 0.0),
    "round before a step moved": lambda p, c: _web_step(p, c, 0.0, 0.6),
}
