"""Members of many families, each as solid and as mesh: is any read as another one without a word?

    python benchmarks/ifc_volumes.py [SEEDS] [--family NAME ...] [--first N] [--verbose]

Each part that was read is built again by the geometry kernel from its own numbers and measured
beside the member that went in. Printed is what became of how many; a member that differs by more
than 0.1 cm3 without an error or a warning is named, and the exit status is 1 then.

The families of tests/property/ifc_cuts.py are written plainly. Those of here are: slotted holes,
notched plates, sections with an outline of their own, and all of them together with openings as
elements, mapped items, turned placements, inches and metres.
"""

import sys
from collections import Counter
from math import acos, cos, hypot, pi, radians, sin, tan
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from msgspec import Struct  # noqa: E402

from beamcam.errors import Severity  # noqa: E402
from beamcam.model.part import Part  # noqa: E402
from beamcam.readers.ifc import Options, read  # noqa: E402
from beamcam.readers.reading import Reading  # noqa: E402
from benchmarks.script import arguments, at_least, start  # noqa: E402
from tests.property.ifc_builder import Vec  # noqa: E402
from tests.property.ifc_cuts import (  # noqa: E402
    FAMILIES,
    Bar,
    Cuts,
    Cutter,
    Half,
    Round,
    kernel_volume,
    meshed,
    model_of,
    remade,
    same,
    shape_of,
    some_bar,
    volumes,
    walls,
)
from tests.unit.readers.ifc.models import Small  # noqa: E402

CHECKED = Options(kernel=True)


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


def slotted(random: Random) -> tuple[Bar, bytes]:
    """Slots of any angle through walls, some blind, some over an edge or an end."""
    bar = some_bar(random)
    made = Cuts()
    taken = []
    for _ in range(random.randint(1, 4)):
        normal, low, high, width = random.choice(list(walls(bar).values()))
        d, long = random.choice((14.0, 18.0, 22.0)), random.uniform(3, 60)
        x = random.choice((random.uniform(0, 60), random.uniform(100, bar.length - 100)))
        q = random.uniform(0, width)
        turn = random.choice((0.0, 0.0, pi / 2, random.uniform(0, pi)))
        deep = random.choice((3.0, 3.0, 3.0, -0.4 * (high - low)))  # beyond the wall, or within
        above = random.random() < 0.5
        depths = (low - deep, high + 3.0) if above else (low - 3.0, high + deep)
        taken.append(made.prism(bar, stadium(x, q, d, long, turn), normal, *depths))
    item = made.small.extruded(made.profile(bar), bar.length)
    made.small.element(made.small.minus(item, *taken))
    return bar, made.small.data


def stadium(x: float, q: float, d: float, long: float, turn: float) -> list[tuple[float, float]]:
    """A slot as exporters without arcs write it."""
    out = []
    for end, begin in ((1, -pi / 2), (-1, pi / 2)):
        for k in range(13):
            t = begin + pi * k / 12
            a, b = end * long / 2 + d / 2 * cos(t), d / 2 * sin(t)
            out.append((x + a * cos(turn) - b * sin(turn), q + a * sin(turn) + b * cos(turn)))
    return out


def plates(random: Random) -> tuple[Bar, bytes]:
    """Plates whose corners are notched, cut or rounded, with holes and hollows."""
    m = Small()
    long, wide, t = random.uniform(150, 900), random.uniform(80, 400), random.uniform(4, 40)
    turn = radians(random.choice((0.0, 0.0, random.uniform(0, 90))))

    def at(x: float, y: float) -> tuple[float, float]:
        return x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)

    ring: list[tuple[float, float]] = []
    corners = ((0.0, 0.0, 1, 1), (long, 0.0, -1, 1), (long, wide, -1, -1), (0.0, wide, 1, -1))
    for i, (x, y, sx, sy) in enumerate(corners):
        dx, dy = random.uniform(5, 0.3 * long), random.uniform(5, 0.3 * wide)
        kind = random.choice(("sharp", "notch", "cut", "round"))
        ahead, after = (x + sx * dx, y), (x, y + sy * dy)
        if i % 2 == 0:
            ahead, after = after, ahead
        if kind == "sharp":
            ring.append((x, y))
        elif kind == "notch":
            ring += [ahead, (x + sx * dx, y + sy * dy), after]
        elif kind == "cut":
            ring += [ahead, after]
        else:
            r = min(dx, dy)
            cx, cy = x + sx * r, y + sy * r
            first = {0: pi, 1: -pi / 2, 2: 0.0, 3: pi / 2}[i]
            ring += [
                (cx + r * cos(first + pi / 2 * k / 40), cy + r * sin(first + pi / 2 * k / 40))
                for k in range(41)
            ]
    points = [m.step.point(*at(*p)) for p in ring]
    outer = m.add(f"IFCPOLYLINE(({','.join([*points, points[0]])}))")
    hollows = []
    for _ in range(random.randint(0, 3)):
        x, y = random.uniform(0.35, 0.65) * long, random.uniform(0.35, 0.65) * wide
        r = random.uniform(4, 0.03 * min(long, wide) + 4)
        spot = m.add(f"IFCAXIS2PLACEMENT2D({m.step.point(*at(x, y))},$)")
        if all(abs(x - u) + abs(y - v) > 3 * (r + s) for u, v, s, _ in hollows):
            hollows.append((x, y, r, m.add(f"IFCCIRCLE({spot},{m.step.length(r)})")))
    if hollows:
        inner = ",".join(h[3] for h in hollows)
        profile = m.add(f"IFCARBITRARYPROFILEDEFWITHVOIDS(.AREA.,$,{outer},({inner}))")
    else:
        profile = m.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{outer})")
    body = m.extruded(profile, t)
    if random.random() < 0.5:
        o = (-5.0, *at(0.3 * long, 0.5 * wide))
        body = m.minus(body, m.hole(o, (1, 0, 0), random.choice((14.0, 18.0, 22.0)), t + 10))
    m.element(body, random.choice(("IFCPLATE", "IFCBEAM")))
    return Bar("B", long, (wide, t, 0.0, t, 0.0)), m.data


def special(random: Random) -> tuple[Bar, bytes]:
    """Asymmetric I, Z, channels with lips, gutters and corners: with mitres and holes."""
    m = Small()
    kind = random.choice(("asymmetric", "asymmetric", "z", "c", "gutter", "hexagon"))
    h, b, t = random.uniform(100, 400), random.uniform(60, 200), random.uniform(3, 15)
    if kind == "asymmetric":
        c, u, r = random.uniform(60, 200), random.uniform(5, 20), random.choice((0.0, 8.0))
        profile = m.add(
            f"IFCASYMMETRICISHAPEPROFILEDEF(.AREA.,$,{m.flat},{b},{h},{t},{u},{r},{c},{u + 2},{r},"
            "$,$,$,$)"
        )
    elif kind == "z":
        profile = m.add(f"IFCZSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{t},{t + 1},0.,$)")
    elif kind == "c":
        girth, r = random.uniform(0.12, 0.25) * h, random.choice((0.0, 3.0))
        profile = m.add(f"IFCCSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{t / 2},{girth},{r})")
    elif kind == "gutter":
        ring = [(0, 0), (b, 0), (b, h / 2), (b - t, h / 2), (b - t, t), (t, t), (t, h), (0, h)]
        profile = m.polygon(*ring)
    else:
        profile = m.polygon(*((b * cos(pi * k / 3), b * sin(pi * k / 3)) for k in range(6)))
    length = random.uniform(600, 2500)
    body = m.extruded(profile, length)
    if random.random() < 0.4:
        turn = radians(random.uniform(-40, 40))
        way = random.choice(((cos(turn), sin(turn), 0.0), (cos(turn), 0.0, sin(turn))))
        body = m.minus(body, m.half((length - 150.0, 0.0, 0.0), way))
    if random.random() < 0.3:
        o = (random.uniform(200, length - 400), -500.0, random.uniform(-0.3, 0.3) * h)
        body = m.minus(body, m.hole(o, (0, 1, 0), 18.0, 1000.0))
    m.element(body)
    return Bar("SO", length, (h, b, t, t, 0.0)), m.data


def kinked(random: Random) -> tuple[Bar, bytes]:
    """Bars of two pieces, curved ones and tapered ones: never a straight one in silence."""
    m = Small()
    profile = random.choice((m.ipe300(), m.box(20, 90), m.circle(60.0)))
    turn = radians(random.uniform(0.3, 60))
    x, y = cos(turn), sin(turn)
    kind = random.choice(("kinked", "curved", "shifted"))
    if kind == "curved":
        axis = m.add(
            f"IFCAXIS1PLACEMENT({m.step.point(0, random.uniform(800, 9000), 0)},"
            f"{m.step.direction(1, 0, 0)})"
        )
        at = m.step.axes((0, 0, 0), (1, 0, 0), (0, 1, 0))
        angle = m.step.num(random.uniform(3, 60))
        body = m.add(f"IFCREVOLVEDAREASOLID({profile},{at},{axis},{angle})")
    else:
        o: Vec = (990.0, 0.0, 0.0) if kind == "kinked" else (990.0, random.uniform(0.5, 30), 0.0)
        way = (x, y, 0.0) if kind == "kinked" else (1.0, 0.0, 0.0)
        far = m.step.axes(o, way, (-way[1], way[0], 0.0))
        pieces = m.extruded(profile, 1000.0), m.extruded(profile, random.uniform(300, 1500), far)
        body = m.add(f"IFCBOOLEANRESULT(.UNION.,{pieces[0]},{pieces[1]})")
    m.element(body)
    return Bar("I", 1000.0, (300.0, 150.0, 10.7, 7.1, 15.0)), m.data


def round_holes(random: Random) -> tuple[Bar, bytes]:
    """Tubes with holes through their axis, all that a drill can make."""
    bar = some_bar(random, "RO RO RU M")
    h, b = bar.sizes[:2]
    cutters: list[Cutter] = []
    for _ in range(random.randint(1, 6)):
        x, along = random.uniform(80, bar.length - 80), random.choice((1, 2))
        q = (b, h)[along - 1] / 2 if bar.code != "M" else random.uniform(25, (b, h)[along - 1] - 25)
        at = [x, q, q]
        at[along] = random.choice((-10.0, -10.0, (h, b)[along - 1] / 2))
        cutters.append(Round((at[0], at[1], at[2]), along, random.uniform(8, 0.3 * b), h + 30.0))
    return bar, model_of(bar, cutters)


def plain(name: str) -> object:
    def made(random: Random) -> tuple[Bar, bytes]:
        bar, cutters = FAMILIES[name](random)
        return bar, model_of(bar, cutters)

    return made


MORE = {
    "slotted": slotted, "plates": plates, "special": special, "kinked": kinked,
    "round_holes": round_holes, "anyhow": written_anyhow,
}  # fmt: skip


def rebuilt(part: Part, bar: Bar) -> bytes:
    """A model of what was read."""
    if part.section:
        return outlined_again(part)
    made, body = remade(part, shape_of(part, bar))
    made.small.element(body)
    return made.small.data


def outlined_again(part: Part) -> bytes:
    """A special section has its outline, its length and its end cuts, and nothing else."""
    made = Cuts()
    points = ring_of(part)
    whole = Bar("SO", part.length, (part.profile.height, part.profile.width, 0.0, 0.0, 0.0))
    taken: list[str] = []
    c = part.cuts
    for side, web, flange in ((-1, c.web_start, c.flange_start), (1, c.web_end, c.flange_end)):
        slope, lean = -tan(radians(web)), -tan(radians(flange))
        if web or flange:
            h, b = part.profile.height, part.profile.width
            reach = [slope * y + lean * z for y in (0.0, h) for z in (0.0, b)]
            x = part.length - max(reach) if side > 0 else -min(reach)
            taken.append(
                made.cutter(whole, Half((x, 0.0, 0.0), (side, -side * slope, -side * lean)))
            )
    profile = made.small.polygon(*(tuple(made.point(whole, (0.0, y, z))[1:]) for y, z in points))
    body = made.small.minus(made.small.extruded(profile, part.length), *taken)
    made.small.element(body)
    return made.small.data


def ring_of(part: Part) -> list[tuple[float, float]]:
    """The outline of a special section in (Y, Z), its arcs in steps of a degree."""
    out: list[tuple[float, float]] = []
    points = part.section
    for a, b in zip(points, (*points[1:], points[0]), strict=True):
        out.append((a.y, a.z))
        if not a.radius:
            continue
        r, dy, dz = abs(a.radius), b.y - a.y, b.z - a.z
        chord = hypot(dy, dz)
        turn = acos(max(-1.0, 1 - chord * chord / (2 * r * r)))
        sense = -1.0 if a.radius > 0 else 1.0
        # The centre lies to one side of the chord; the arc bulges to the other.
        off = (r * r - chord * chord / 4) ** 0.5 * sense
        cy, cz = (a.y + b.y) / 2 + off * dz / chord, (a.z + b.z) / 2 - off * dy / chord
        for k in range(1, 90):
            t = sense * turn * k / 90
            u, v = a.y - cy, a.z - cz
            out.append((cy + u * cos(t) + v * sin(t), cz - u * sin(t) + v * cos(t)))
    return out


def outcome(bar: Bar, data: bytes, written: bytes, reading: Reading) -> str:
    """What became of a member: read, told with a word, refused; or silently another one.

    `written` is its mesh, if that was read, whose chords may leave less than `data` has.
    """
    said = sorted({d.code for d in reading.diagnostics if d.severity is not Severity.NOTE})
    if not reading.parts:
        return "refused " + ",".join(said) if said else "SILENTLY left out"
    if said:
        return "told " + ",".join(said)
    (part,) = reading.parts
    if part.profile.code == "C":
        return "read, its lips are no measures"
    if part.profile.code == "L" and part.profile.flange_thickness != part.profile.web_thickness:
        return "read, IFC has no angle of two thicknesses to measure it by"
    again = rebuilt(part, bar)
    pairs = [pair for one in (data, written) if (pair := volumes(one, again)) is not None]
    if not pairs:
        return "not measured"
    if any(same(*pair) for pair in pairs):
        return "read"
    return f"SILENTLY {pairs[0][1] - pairs[0][0]:+.3f} of {pairs[0][0]:.2f} cm3"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("seeds", nargs="?", type=at_least(1), default=100, help="default 100")
    parser.add_argument("--family", action="append", choices=[*FAMILIES, *MORE], default=[])
    parser.add_argument("--first", type=at_least(0), default=0, help="the first seed")
    parser.add_argument("--verbose", action="store_true", help="name refused ones as well")
    asked = parser.parse_args()
    families = {**{name: plain(name) for name in FAMILIES}, **MORE}
    silent = 0
    for name in asked.family or families:
        for mesh in (False, True):
            rows: Counter[str] = Counter()
            lines = []
            for seed in range(asked.first, asked.first + asked.seeds):
                bar, data = families[name](Random(f"{name}{seed}"))  # type: ignore[operator]
                if not kernel_volume(data):
                    rows["no solid"] += 1
                    continue
                written = meshed(data) if mesh else data
                reading = read(written, "m.ifc", options=CHECKED)
                row = outcome(bar, data, written, reading)
                rows["SILENT" if "SILENTLY" in row else row] += 1
                silent += "SILENTLY" in row
                if "SILENTLY" in row or (asked.verbose and "refused" in row):
                    lines.append(f"    {seed}: {row} {_first(reading)}")
            print(name, "meshes" if mesh else "solids", dict(rows.most_common()))
            print(*lines, sep="\n", end="\n" if lines else "")
    sys.exit(1 if silent else 0)


def _first(reading: Reading) -> str:
    return next((d.message for d in reading.diagnostics if d.severity is Severity.ERROR), "")


if __name__ == "__main__":
    start(main)
