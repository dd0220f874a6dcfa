"""Members of tests/property/ifc_cut_families.py, written in any of the ways there are.

With openings as elements, as mapped items, in turned placements, in inches and metres.
"""

from math import cos, pi, sin
from random import Random

from msgspec import Struct

from tests.property.ifc_cut_families import FAMILIES
from tests.property.ifc_cuts import Bar, Cuts, Cutter, Half
from tests.unit.readers.ifc.models import Small


class Written(Struct, frozen=True):
    """How a member is written."""

    unit: str = "mm"
    schema: str = "IFC4"
    openings: bool = False  #: cutters are elements of their own
    mapped: bool = False
    turned: bool = False  #: it stands anywhere, as its opening elements do


class Anyhow(Cuts):
    """A model in another unit, with other ways to say the same."""

    def __init__(self, how: Written, random: Random) -> None:
        self.small = Small(how.schema, how.unit)
        self.step = self.small.step
        self.how, self.random = how, random

    def profile(self, bar: Bar) -> str:
        """As of millimetres, with all lengths in the unit of the file."""
        scaled = Bar(bar.code, bar.length, tuple(v * self.step.scale for v in bar.sizes))  # type: ignore[arg-type]
        if bar.code == "B":
            return super().profile(bar)  # which takes millimetres
        return super().profile(scaled)

    def whole(self, bar: Bar, cutters: list[Cutter]) -> bytes:
        m, how = self.small, self.how
        body = m.extruded(self.profile(bar), bar.length)
        placement = self._somewhere("$") if how.turned else m.placement
        inside, outside = (list(cutters), []) if not how.openings else ([], list(cutters))
        halves = [c for c in outside if isinstance(c, Half)]  # an opening is a closed solid
        body = m.minus(body, *(self.cutter(bar, c) for c in (*inside, *halves)))
        if how.mapped:
            body = self._mapped(body)
        kind = "MappedRepresentation" if how.mapped else "CSG"
        element = m.element(body, kind_of_body=kind, placement=placement)
        for cutter in outside:
            if not isinstance(cutter, Half):
                self._opening(element, placement, self.cutter(bar, cutter))
        return m.data

    def _somewhere(self, after: str) -> str:
        r, step = self.random, self.step
        turn, lean = r.uniform(0, 2 * pi), r.uniform(-1, 1)
        x = (cos(turn) * cos(lean), sin(turn) * cos(lean), sin(lean))
        z = (-cos(turn) * sin(lean), -sin(turn) * sin(lean), cos(lean))
        o = (r.uniform(-1e5, 1e5), r.uniform(-1e5, 1e5), r.uniform(-1e4, 1e4))
        return step.add(f"IFCLOCALPLACEMENT({after},{step.axes(o, z, x)})")

    def _mapped(self, body: str) -> str:
        """A body by way of a map that turns it to and fro."""
        step = self.step
        origin = step.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))
        shape = step.add(f"IFCSHAPEREPRESENTATION({step.context},'Body','CSG',({body}))")
        source = step.add(f"IFCREPRESENTATIONMAP({origin},{shape})")
        mirror = -1 if self.random.random() < 0.3 else 1
        axes = [step.direction(*v) for v in ((0, 1, 0), (-1, 0, 0), (0, 0, mirror))]
        o = step.point(*(self.random.uniform(-500, 500) for _ in range(3)))
        target = step.add(
            f"IFCCARTESIANTRANSFORMATIONOPERATOR3D({axes[0]},{axes[1]},{o},1.,{axes[2]})"
        )
        return step.add(f"IFCMAPPEDITEM({source},{target})")

    def _opening(self, element: str, placement: str, solid: str) -> None:
        step = self.step
        shape = step.add(f"IFCSHAPEREPRESENTATION({step.context},'Body','SweptSolid',({solid}))")
        product = step.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        own = step.add(
            f"IFCLOCALPLACEMENT({placement},{step.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))})"
        )
        last = "" if step.schema == "IFC2X3" else ",$"
        opening = step.add(
            f"IFCOPENINGELEMENT('{step.guid()}',{step.owner},$,$,$,{own},{product},${last})"
        )
        step.add(f"IFCRELVOIDSELEMENT('{step.guid()}',{step.owner},$,$,{element},{opening})")


def some_way(random: Random) -> Written:
    unit = random.choice(("mm", "inch", "metre"))
    schema = random.choice(("IFC2X3", "IFC4", "IFC4X3_ADD2"))
    openings, mapped, turned = (random.random() < 0.5 for _ in range(3))
    return Written(unit, schema, openings, mapped and not openings, turned)


def written_anyhow(random: Random) -> tuple[Bar, bytes]:
    bar, cutters = FAMILIES[random.choice(list(FAMILIES))](random)
    return bar, Anyhow(some_way(random), random).whole(bar, list(cutters))
