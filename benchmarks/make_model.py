"""Makes a building model as Tekla writes it: rolled members, fittings, holes, property sets.

    python benchmarks/make_model.py OUT.ifc [MEMBERS] [--bent N]

Sections are the catalogue's. A piece stands in the building three times on average, each time
written anew. A member has 2 fittings, 0 to 12 holes in rows, and 4 property sets of 25 values,
which is what real exports have: two records in five are no geometry. N bent accessories (Breps that
are no members) may stand beside them.
"""

import sys
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from beamcam.model.section import sections  # noqa: E402
from benchmarks.bent_accessories import add_bent, bent  # noqa: E402
from benchmarks.script import arguments, at_least, start  # noqa: E402
from tests.property.ifc_builder import HoleSpec, Member, Writer, walls  # noqa: E402

SETS = {
    "Tekla Common": ("Class", "Phase", "Preliminary mark", "Initial GUID", "Start", "End"),
    "Tekla Quantity": ("Height", "Width", "Length", "Weight", "Net weight", "Volume",
                       "Gross footprint area", "Area per tons", "Net surface area"),
    "Tekla Assembly": ("Assembly/Cast unit Mark", "Assembly/Cast unit top elevation",
                       "Assembly/Cast unit bottom elevation", "Assembly/Cast unit weight",
                       "Assembly/Cast unit position code", "Assembly/Cast unit hierarchy"),
    "Pset_BeamCommon": ("Reference", "LoadBearing", "Span", "Slope"),
}  # fmt: skip


def piece(random: Random, number: int) -> Member:
    """A rolled member with rows of holes at its ends and along it."""
    rolled = [(code, s) for code, s in sections().values() if code in ("I", "U", "L") and s[0] > 90]
    code, (h, b, tf, tw, _) = random.choice(rolled)
    length = float(random.randint(20, 120) * 100)
    member = Member(code, (h, b, tf, tw), length, ((0.0, 0.0), (0.0, 0.0)), (), mark=f"P{number}")
    wall = walls(member)[0]
    rows = random.choice((1, 2, 2, 3))
    xs = [random.choice((40.0, 60.0)), length - 50.0]
    xs += sorted(float(random.randint(3, int(length / 100) - 3) * 100 + 7) for _ in range(2))
    holes = []
    for x in xs[: random.randint(0, 4)]:
        for k in range(rows):
            q = h / 2 + (k - (rows - 1) / 2) * 0.25 * h
            holes.append(HoleSpec(wall.face, x, round(q, 2), random.choice((14.0, 18.0, 22.0))))
    skew = (round(random.uniform(-30, 30), 1), 0.0) if random.random() < 0.2 else (0.0, 0.0)
    clear = [x for x in holes if abs(skew[0]) < 0.1 or h * 0.6 < x.x < length - h * 0.6]
    return Member(code, member.sizes, length, (skew, skew), tuple(clear), mark=member.mark)


class Tekla(Writer):
    """A writer that says of each member what Tekla says."""

    def describe(self, member: Member, element: str) -> None:
        step = self.step
        material = step.add("IFCMATERIAL('STEEL/S355J2')")
        step.add(
            f"IFCRELASSOCIATESMATERIAL('{step.guid()}',{step.owner},$,$,({element}),{material})"
        )
        for name, properties in SETS.items():
            rows = [step.add(self._property(member, p)) for p in properties]
            found = step.add(
                f"IFCPROPERTYSET('{step.guid()}',{step.owner},'{name}',$,({','.join(rows)}))"
            )
            step.add(
                f"IFCRELDEFINESBYPROPERTIES('{step.guid()}',{step.owner},$,$,({element}),{found})"
            )

    def _property(self, member: Member, name: str) -> str:
        value = {
            "Length": f"IFCLENGTHMEASURE({self.step.num(member.length)})",
            "Height": f"IFCLENGTHMEASURE({self.step.num(member.sizes[0])})",
            "Width": f"IFCLENGTHMEASURE({self.step.num(member.sizes[1])})",
            "Phase": "IFCLABEL('1')",
            "Reference": f"IFCLABEL('{member.mark}')",
            "Assembly/Cast unit Mark": f"IFCLABEL('A{member.mark[1:]}')",
            "LoadBearing": "IFCBOOLEAN(.T.)",
        }.get(name, "IFCLABEL('12.5')")
        return f"IFCPROPERTYSINGLEVALUE('{name}',$,{value},$)"


def model(count: int, seed: str = "tekla", bents: int = 0) -> str:
    """The text of a model of `count` members and so many bent accessories."""
    random = Random(seed)
    writer = Tekla("csg", random)
    pieces = [piece(random, i) for i in range(max(1, count // 3))]
    for _ in range(count):
        member = random.choice(pieces)
        writer.add(member)
        writer.describe(member, f"#{len(writer.step.lines)}")
    for i in range(bents):
        placement = writer.step.add(f"IFCLOCALPLACEMENT($,{writer.step.world})")
        add_bent(writer.step, placement, bent(random), f"S{i}")
    return writer.step.text()


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("members", nargs="?", type=at_least(1), default=3000, help="default 3000")
    parser.add_argument("--bent", type=int, default=0, metavar="N", help="bent accessories")
    asked = parser.parse_args()
    text = model(asked.members, bents=asked.bent)
    asked.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    start(main)
