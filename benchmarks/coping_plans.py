"""Ways to make the plan of a coper wrong, by what a planner could get wrong."""

import random
from collections.abc import Callable
from math import atan, degrees, hypot, radians, tan

from msgspec.structs import replace

from beamcam.machine import Machine
from beamcam.model.plan import CopeCut, CopePlan
from beamcam.model.surface import around
from benchmarks.coping_bevels import BEVEL_PLANS, OfPlan, changed, turned
from benchmarks.coping_roots import STEPS, along_the_lip, lip_left_out, lip_too_shallow


def _placed(change: Callable[[float, float], tuple[float, float]]) -> OfPlan:
    def of_plan(plan: CopePlan, chance: random.Random) -> CopePlan | None:
        return changed(
            plan, chance, lambda cut: replace(cut, path=tuple(change(*p) for p in cut.path))
        )

    return of_plan


def mirrored_along(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut at the other end of the part, if it does not go round both."""
    length = plan.pieces[0].part.length

    def is_alike(cut: CopeCut) -> bool:
        xs = [x for x, _ in cut.path[cut.lead :]]
        return abs(min(xs) + max(xs) - length) < 1.0

    return changed(
        plan, chance,
        lambda cut: replace(cut, path=tuple((length - x, y) for x, y in cut.path)),
        lambda cut: not is_alike(cut),
    )  # fmt: skip


def mirrored_across(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A hole whose y counts from the other edge."""

    def off_middle(cut: CopeCut) -> bool:
        ys = [y for _, y in cut.path[cut.lead :]]
        wide = plan.profile.face_width(cut.face)
        return cut.kind == "inner" and abs(min(ys) + max(ys) - wide) > 1.0

    def change(cut: CopeCut) -> CopeCut:
        wide = plan.profile.face_width(cut.face)
        return replace(cut, path=tuple((x, wide - y) for x, y in cut.path))

    return changed(plan, chance, change, off_middle)


def on_the_part(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut whose kerf lies on the side of the part."""
    from shapely import LineString, Polygon

    def change(cut: CopeCut) -> CopeCut | None:
        way, kerf = cut.path[cut.lead :], cut.row.kerf
        if cut.kind == "inner":
            ring = Polygon(way).buffer(kerf).exterior.coords
            return replace(cut, path=tuple(ring), lead=0)
        pierce, start = cut.path[0], cut.path[1]
        side = 1.0 if LineString(way).parallel_offset(1.0, "left").distance(
            LineString([pierce, start]).interpolate(0.0)
        ) > LineString(way).parallel_offset(1.0, "right").distance(
            LineString([pierce, start]).interpolate(0.0)
        ) else -1.0  # fmt: skip
        moved = LineString(way).offset_curve(side * kerf)
        longest = max(getattr(moved, "geoms", (moved,)), key=lambda one: one.length)
        return replace(cut, path=(pierce, *longest.coords))

    return changed(plan, chance, change, lambda cut: not cut.turns)


def left_out(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut that is missing; a second pass that is, is told as manual work."""
    k = chance.choice([k for k, cut in enumerate(plan.operations) if not cut.bevel])
    return replace(plan, operations=(*plan.operations[:k], *plan.operations[k + 1 :]))


def face_left_out(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A wall without its cuts."""
    face = chance.choice(sorted({cut.face for cut in plan.operations}))
    return replace(plan, operations=tuple(c for c in plan.operations if c.face != face))


def on_other_face(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut of one flange on the other one, where that differs from its own cuts."""

    def change(cut: CopeCut) -> CopeCut | None:
        other = "u" if cut.face == "o" else "o"
        same = [c for c in plan.operations if c.face == other and c.path == cut.path]
        return None if same else replace(cut, face=other)

    return changed(plan, chance, change, lambda c: c.face != "v" and plan.profile.code not in "LT")


def too_short(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut that ends too early; where a second pass goes along it, that may take what it left."""
    again = {(cut.face, cut.kind) for cut in plan.operations if cut.b_deg or cut.bevel}
    return changed(
        plan, chance, lambda cut: replace(cut, path=_shortened(cut.path, 9.0)),
        lambda cut: len(cut.path) > 2 and not cut.bevel
        and (bool(cut.b_deg) or (cut.face, cut.kind) not in again),
    )  # fmt: skip


def _shortened(path: tuple[tuple[float, float], ...], by: float) -> tuple[tuple[float, float], ...]:
    points = list(path)
    while len(points) > 1:
        (xa, ya), (xb, yb) = points[-2:]
        long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5
        if long > by:
            share = (long - by) / long
            points[-1] = xa + share * (xb - xa), ya + share * (yb - ya)
            return tuple(points)
        by -= long
        points.pop()
    return tuple(points)


def twice(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut-out that is cut twice."""
    k = chance.randrange(len(plan.operations))
    cut = plan.operations[k]
    return replace(plan, operations=(*plan.operations[:k], cut, *plan.operations[k:]))


def reordered(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut of the far end before all others."""
    far = [cut for cut in plan.operations if cut.kind == "far"]
    rest = [cut for cut in plan.operations if cut is not far[0]]
    return replace(plan, operations=(far[0], *rest)) if rest[0].kind != "far" else None


def pierced_in_part(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A lead on the other side of its contour; that of a bevel lies in scrap there too."""

    def change(cut: CopeCut) -> CopeCut:
        (xa, ya), (xb, yb) = cut.path[:2]
        return replace(cut, path=((2 * xb - xa, 2 * yb - ya), *cut.path[1:]))

    return changed(
        plan, chance, change,
        lambda cut: (cut.kind == "inner" or cut.face == "v") and not cut.bevel,
    )  # fmt: skip


def bevel_pierced_in_part(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A pass along a bevel that is pierced in the steel behind the middle of its edge."""

    def change(cut: CopeCut) -> CopeCut:
        (xa, ya), (xb, yb), (xc, yc) = cut.path[:3]
        share = hypot(xb - xa, yb - ya) / hypot(xc - xb, yc - yb)
        inside = (xb + xc) / 2 - (yc - yb) * share, (yb + yc) / 2 + (xc - xb) * share
        return replace(cut, path=(inside, *cut.path[1:]))

    return changed(plan, chance, change, lambda cut: cut.bevel and not cut.turns)


def other_row(machine: Machine) -> OfPlan:
    """A cut with the row of another thickness."""

    def of_plan(plan: CopePlan, chance: random.Random) -> CopePlan | None:
        rows = machine.coper.rows if machine.coper else ()
        return changed(
            plan, chance,
            lambda cut: replace(cut, row=chance.choice([r for r in rows if r != cut.row])),
        )  # fmt: skip

    return of_plan


def bulge(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A place of a path 1 mm into the part."""

    def change(cut: CopeCut) -> CopeCut:
        k = chance.randrange(cut.lead + 1, len(cut.path) - 1)
        (xa, ya), (xb, yb) = cut.path[k - 1], cut.path[k + 1]
        long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5 or 1.0
        x, y = cut.path[k]
        moved = x - (yb - ya) / long, y + (xb - xa) / long  # the part lies on the left
        return replace(cut, path=(*cut.path[:k], moved, *cut.path[k + 1 :]))

    return changed(
        plan, chance, change,
        lambda cut: cut.kind == "inner" and len(cut.path) > cut.lead + 4,
    )  # fmt: skip


def extra(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut somewhere in the scrap before the part."""
    cut = plan.operations[0]
    return replace(plan, operations=(
        replace(cut, path=((-20.0, 60.0), (-20.0, 40.0), (-20.0, 61.0)), turns=()),
        *plan.operations,
    ))  # fmt: skip


def mirrored_round(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut-out of a tube whose arc counts the other way round."""
    turn = around(plan.profile).turn

    def is_same(cut: CopeCut) -> bool:
        us = [u for _, u in cut.path[cut.lead :]]
        return abs((min(us) + max(us) + turn / 2) % turn - turn / 2) < 1.0

    return changed(
        plan, chance,
        lambda cut: replace(cut, path=tuple((x, -u) for x, u in cut.path)),
        lambda cut: cut.kind == "inner" and not is_same(cut),
    )  # fmt: skip


def elsewhere_round(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A cut-out of a tube a quarter of a turn on."""
    turn = around(plan.profile).turn
    return changed(
        plan, chance,
        lambda cut: replace(cut, path=tuple((x, u + turn / 4) for x, u in cut.path)),
        lambda cut: cut.kind == "inner",
    )  # fmt: skip


def other_corners(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A rectangular tube with corners of another radius."""
    profile = plan.profile
    if profile.code != "M":
        return None
    return replace(
        plan, profile=replace(profile, radius=profile.radius * chance.choice((0.8, 1.2)))
    )


def elsewhere_on_the_seam(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """An end of a tube that is square, or of a round tube any, begun half a turn away."""
    turn = around(plan.profile).turn

    def is_square(cut: CopeCut) -> bool:
        xs = [x for x, _ in cut.path[cut.lead :]]
        return cut.kind != "inner" and max(xs) - min(xs) < 1e-6

    return changed(
        plan, chance,
        lambda cut: replace(cut, path=tuple((x, u + turn / 2) for x, u in cut.path)), is_square,
    )  # fmt: skip


def ends_before_the_seam(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """An end of a tube that is not cut all round."""
    return changed(
        plan, chance, lambda cut: replace(cut, path=_shortened(cut.path, 6.0)),
        lambda cut: cut.kind != "inner",
    )  # fmt: skip


def is_tilted(cut: CopeCut) -> bool:
    """Whether B leaves 0 by enough to matter."""
    return max(abs(b_deg) for _, b_deg in (*cut.turns, (0.0, cut.b_deg))) > 3.0


def _seen(plan: CopePlan, cut: CopeCut) -> float:
    """Degrees of a tilt that are more than the tolerance of what is cut: of a thin wall many."""
    thick = plan.profile.thickness(cut.face)
    return 3.0 if cut.lip or thick > 6.0 else degrees(atan(0.6 / thick))


def _off_by(plan: CopePlan, chance: random.Random, sign: float) -> CopePlan | None:
    """A cut whose B is another one by what is seen."""
    return changed(
        plan, chance,
        lambda cut: turned(cut, lambda t: (t[0], t[1] + sign * _seen(plan, cut))), is_tilted,
    )  # fmt: skip


#: Ways to make the tilt of a cut wrong.
TILTS: dict[str, OfPlan] = {
    "B the other way": lambda p, c: changed(
        p, c, lambda cut: turned(cut, lambda t: (t[0], -t[1])), is_tilted
    ),
    "B dropped": lambda p, c: changed(
        p, c, lambda cut: turned(cut, lambda t: (t[0], 0.0)), is_tilted
    ),
    "B of another angle": lambda p, c: _off_by(p, c, c.choice((-1.0, 1.0))),
    "B at all ends the other way": lambda p, c: replace(
        p, operations=tuple(turned(cut, lambda t: (t[0], -t[1])) for cut in p.operations)
    ) if any(map(is_tilted, p.operations)) else None,
}  # fmt: skip


def wrong_land(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A bevel whose land is another one by 1 mm."""

    def change(cut: CopeCut) -> CopeCut:
        off = chance.choice((-1.0, 1.0)) * tan(radians(abs(cut.b_deg)))
        return replace(cut, path=(cut.path[0], *((x + off, y) for x, y in cut.path[1:])))

    return changed(plan, chance, change, lambda cut: cut.bevel and is_across(cut))


def is_across(cut: CopeCut) -> bool:
    """Whether a bevel goes straight across the bar."""
    return not cut.turns and not cut.a_off_deg


def bevel_first(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A bevel before the square cut along its edge."""
    which = [k for k, cut in enumerate(plan.operations) if cut.bevel and not cut.lower]
    if not which:
        return None
    k = chance.choice(which)
    cut = plan.operations[k]
    rest = [one for one in plan.operations if one is not cut]
    own = [j for j, one in enumerate(rest)
           if (one.kind, one.face) == (cut.kind, cut.face) and not one.bevel]  # fmt: skip
    if not own:  # of an edge that the bar has
        return None
    at = own[0]
    return replace(plan, operations=(*rest[:at], cut, *rest[at:]))


def bevel_last(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A bevel of the far end of a piece that is parted."""
    which = [cut for cut in plan.operations if cut.bevel and cut.kind == "far"]
    if not which:
        return None
    cut = chance.choice(which)
    rest = [one for one in plan.operations if one is not cut]
    return replace(plan, operations=(*rest, cut)) if plan.operations[-1] is not cut else None


def lower_behind(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A bevel of the far side behind the square cut along its edge, or those beside it."""
    which = [cut for cut in plan.operations if cut.lower and cut.kind != "inner"]
    if not which:
        return None
    cut = chance.choice(which)
    rest = [one for one in plan.operations if one is not cut]
    at = max(j for j, one in enumerate(rest) if (one.kind, one.face) == (cut.kind, cut.face))
    return replace(plan, operations=(*rest[: at + 1], cut, *rest[at + 1 :]))


def plan_faults(machine: Machine, code: str) -> dict[str, OfPlan]:
    """Ways to make the plan of a section wrong."""
    of_all: dict[str, OfPlan] = {
        "moved along": _placed(lambda x, y: (x + 0.6, y)),
        "moved across": lambda p, c: changed(
            p, c, lambda cut: replace(cut, path=tuple((x, y + 0.6) for x, y in cut.path)),
            lambda cut: cut.kind == "inner",
        ),
        "mirrored along": mirrored_along, "cut left out": left_out, "too short": too_short,
        "order": reordered, "twice": twice, "kerf on the part": on_the_part,
        "other row": other_row(machine), "bulge": bulge, "extra": extra,
    }  # fmt: skip
    if machine.coper is not None and machine.coper.unrolls(code):
        return of_all | {
            "mirrored round": mirrored_round, "elsewhere round": elsewhere_round,
            "ends before the seam": ends_before_the_seam, "other corners": other_corners,
            "begun off the seam": elsewhere_on_the_seam,
        }  # fmt: skip
    return of_all | {
        "mirrored across": mirrored_across, "face left out": face_left_out,
        "other face": on_other_face, "pierced in the part": pierced_in_part,
        "bevel pierced in the part": bevel_pierced_in_part,
        **TILTS, **BEVEL_PLANS, "wrong land": wrong_land, "passes in the wrong order": bevel_first,
        "bevel behind the parting": bevel_last, "lower bevel behind": lower_behind,
        "lip left out": lip_left_out, "lip too shallow": lip_too_shallow(machine),
        "along the lip": along_the_lip, **STEPS,
    }  # fmt: skip
