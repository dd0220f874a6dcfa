"""Members of known features, written as IFC in the ways that exporters have.

A `Member` is stated in DSTV's coordinates, as the reader shall give it back; `model_text` writes
it by one of `ENCODINGS`. Nothing here comes from the reader.
"""

from collections.abc import Sequence
from math import atan, cos, degrees, pi, radians, sin, sqrt, tan
from random import Random

from msgspec import Struct, field

Vec = tuple[float, float, float]
Pair = tuple[float, float]

ENCODINGS = ("csg", "openings", "voiding", "mirrored", "inch", "metre", "outline", "brep", "mesh")

IDENTIFIERS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"


class HoleSpec(Struct, frozen=True):
    face: str
    x: float
    q: float
    diameter: float
    slot: float = 0.0  #: centre to centre
    slot_along: bool = True  #: along the member, or across
    both: bool = False  #: through both flanges, or both walls of a tube


class Member(Struct, frozen=True):
    code: str
    sizes: tuple[float, float, float, float]  #: height, width, flange, web
    length: float
    ends: tuple[Pair, Pair]  #: (web, flange) degrees at start and end, DSTV's signs
    holes: tuple[HoleSpec, ...]
    corners: int = 16  #: of a polygon for a hole
    mark: str = "B1"
    chord: bool = field(default=False)


def planes(member: Member) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """(a, b, c) of x = a Y + b Z + c at both ends."""
    out = []
    for side, (web, flange) in zip((-1, 1), member.ends, strict=True):
        slope, lean = -tan(radians(web)), -tan(radians(flange))
        values = [slope * y + lean * z for y, z in section_polygon(member)]
        c = -min(values) if side < 0 else member.length - max(values)
        out.append((slope, lean, c))
    return out[0], out[1]


class WallSpec(Struct, frozen=True):
    face: str
    normal: int  #: 1 is Y, 2 is Z
    low: float
    high: float
    width: float


def walls(member: Member) -> list[WallSpec]:
    h, b, tf, tw = member.sizes
    top, bottom = WallSpec("o", 1, h - tf, h, b), WallSpec("u", 1, 0.0, tf, b)
    match member.code:
        case "I":
            return [WallSpec("v", 2, (b - tw) / 2, (b + tw) / 2, h), top, bottom]
        case "U":
            return [WallSpec("v", 2, 0.0, tw, h), top, bottom]
        case "L":
            return [WallSpec("v", 2, 0.0, tw, h), bottom]
        case "T":
            return [WallSpec("v", 2, 0.0, tw, h), WallSpec("o", 1, (h - tf) / 2, (h + tf) / 2, b)]
        case "M":
            return [WallSpec("v", 2, b - tw, b, h), WallSpec("h", 2, 0.0, tw, h), top, bottom]
    return [WallSpec("v", 2, 0.0, b, h)]


def section_polygon(member: Member) -> list[Pair]:
    """The sharp outline in (Y, Z)."""
    h, b, tf, tw = member.sizes
    match member.code:
        case "I":
            w0, w1 = (b - tw) / 2, (b + tw) / 2
            return [
                (0, 0), (0, b), (tf, b), (tf, w1), (h - tf, w1), (h - tf, b),
                (h, b), (h, 0), (h - tf, 0), (h - tf, w0), (tf, w0), (tf, 0),
            ]  # fmt: skip
        case "U":
            return [(0, 0), (0, b), (tf, b), (tf, tw), (h - tf, tw), (h - tf, b), (h, b), (h, 0)]
        case "L":
            return [(0, 0), (0, b), (tf, b), (tf, tw), (h, tw), (h, 0)]
        case "T":
            s0, s1 = (h - tf) / 2, (h + tf) / 2
            return [(0, 0), (0, tw), (s0, tw), (s0, b), (s1, b), (s1, tw), (h, tw), (h, 0)]
    return [(0, 0), (0, b), (h, b), (h, 0)]


def bore_polygon(member: Member) -> list[Pair]:
    h, b, tf, tw = member.sizes
    if member.code != "M":
        return []
    return [(tf, tw), (tf, b - tw), (h - tf, b - tw), (h - tf, tw)]


class Lie(Struct, frozen=True):
    """How the section lies in its profile's plane: zero point, Y, Z, and which way x runs."""

    origin: Pair
    y: Pair
    z: Pair
    forward: bool = True


def lie(code: str, sizes: Sequence[float]) -> Lie:
    h, b = sizes[:2]
    match code:
        case "U" | "C":
            return Lie((-b / 2, h / 2), (0, -1), (1, 0))
        case "L":
            return Lie((-b / 2, -h / 2), (0, 1), (1, 0), False)
        case "T":
            return Lie((h / 2, b / 2), (-1, 0), (0, -1))
    return Lie((b / 2, -h / 2), (0, 1), (-1, 0))


def expected_holes(member: Member) -> list[tuple[object, ...]]:
    """(face, x, q, diameter, slot, across) of every hole in every wall."""
    out: list[tuple[object, ...]] = []
    for hole in member.holes:
        faces = {"o": ("o", "u"), "v": ("v", "h")}[hole.face] if hole.both else (hole.face,)
        for face in faces:
            out.append(
                (
                    face,
                    round(hole.x, 6),
                    hole.q,
                    hole.diameter,
                    hole.slot,
                    bool(hole.slot) and not hole.slot_along,
                )
            )
    return sorted(out, key=repr)


def random_member(random: Random, encoding: str) -> Member:
    """A member that the encoding can express, its features apart from one another."""
    code = random.choice("IIIUULLTMMB")
    h = round(random.uniform(120, 500), 1)
    b = round(random.uniform(0.35, 0.9) * h, 1)
    tf, tw = round(random.uniform(6, 14), 1), round(random.uniform(5, 10), 1)
    if code in ("M", "L"):
        tf = tw
    if code == "B":
        b = tw = round(random.uniform(6, 25), 1)
        tf = 0.0
    faceted = encoding in ("brep", "mesh")
    length = round(random.uniform(1500, 6000), 1)
    ends = []
    for _ in range(2):
        kind = random.choice(("square", "square", "web", "flange", "both"))
        web = round(random.uniform(-45, 45), 2) if kind in ("web", "both") else 0.0
        flange = round(random.uniform(-40, 40), 2) if kind in ("flange", "both") else 0.0
        if code == "B":
            flange = 0.0
        ends.append((web, flange))
    member = Member(code, (h, b, tf, tw), length, (ends[0], ends[1]), (), random.randint(12, 24))
    reach = max(abs(tan(radians(w))) * h + abs(tan(radians(f))) * b for w, f in ends)
    holes: list[HoleSpec] = []
    x = reach + 80
    while x < length - reach - 80 and len(holes) < 9:
        made = _random_hole(random, member, x, faceted)
        if made is not None:
            holes.append(made)
        x += random.uniform(120, 600)
    return Member(
        code, member.sizes, length, member.ends, tuple(holes), member.corners,
        f"{code}{random.randint(1, 999)}",
    )  # fmt: skip


def _random_hole(random: Random, member: Member, x: float, faceted: bool) -> HoleSpec | None:
    wall = random.choice(walls(member))
    d = float(random.choice((14, 17.5, 18, 22, 26, 33)))
    slot = float(random.choice((0, 0, 0, 20, 40))) if not faceted else 0.0
    along = random.random() < 0.6
    reach = d / 2 + (0 if along else slot / 2) + 3
    ranges = _free(member, wall)
    low, high = random.choice(ranges)
    if high - low <= 2 * reach + 1:
        return None
    q = round(random.uniform(low + reach, high - reach), 2)
    both = (
        (wall.face == "o" and member.code in ("I", "U", "M"))
        or (wall.face == "v" and member.code == "M")
    ) and random.random() < 0.4
    return HoleSpec(wall.face, round(x, 2), q, d, slot, along, both)


def _free(member: Member, wall: WallSpec) -> list[Pair]:
    """Where across a wall a hole meets no other wall."""
    h, b, tf, tw = member.sizes
    if member.code == "B":
        return [(0.0, h)]
    if wall.normal == 2:
        if member.code == "T":
            return [(0.0, (h - tf) / 2), ((h + tf) / 2, h)]
        return [(tf, h if member.code == "L" else h - tf)]
    if member.code == "I":
        return [(0.0, (b - tw) / 2), ((b + tw) / 2, b)]
    return [(tw, b - tw if member.code == "M" else b)]


class Step:
    """Lines of a STEP file."""

    def __init__(self, schema: str, unit: str) -> None:
        self.schema, self.unit = schema, unit
        self.lines: list[str] = []
        self.scale = {"mm": 1.0, "inch": 1 / 25.4, "metre": 1e-3}[unit]
        self.count = 0
        self._start()

    def add(self, text: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def guid(self) -> str:
        self.count += 1
        n, text = self.count, ""
        for _ in range(21):
            text = IDENTIFIERS[n % 64] + text
            n //= 64
        return "0" + text

    def num(self, value: float) -> str:
        text = repr(float(value))
        return text.replace("e", "E") if "." in text else text.replace("e", ".E")

    def length(self, value: float) -> str:
        return self.num(value * self.scale)

    def point(self, *values: float) -> str:
        return self.add(f"IFCCARTESIANPOINT(({','.join(self.length(v) for v in values)}))")

    def direction(self, *values: float) -> str:
        return self.add(f"IFCDIRECTION(({','.join(self.num(v) for v in values)}))")

    def axes(self, o: Vec, z: Vec, x: Vec) -> str:
        return self.add(
            f"IFCAXIS2PLACEMENT3D({self.point(*o)},{self.direction(*z)},{self.direction(*x)})"
        )

    def _start(self) -> None:
        self.owner = "$"
        if self.schema == "IFC2X3":
            person = self.add("IFCPERSON($,'x',$,$,$,$,$,$)")
            organization = self.add("IFCORGANIZATION($,'x',$,$,$)")
            both = self.add(f"IFCPERSONANDORGANIZATION({person},{organization},$)")
            application = self.add(f"IFCAPPLICATION({organization},'1','beamcam tests','tests')")
            self.owner = self.add(f"IFCOWNERHISTORY({both},{application},$,.ADDED.,$,$,$,0)")
        prefix = ".MILLI." if self.unit == "mm" else "$"
        unit = self.add(
            f"IFCSIUNIT(*,.LENGTHUNIT.,{'.MILLI.' if self.unit == 'inch' else prefix},.METRE.)"
        )
        if self.unit == "inch":
            measure = self.add(f"IFCMEASUREWITHUNIT(IFCLENGTHMEASURE(25.4),{unit})")
            exponents = self.add("IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0)")
            unit = self.add(f"IFCCONVERSIONBASEDUNIT({exponents},.LENGTHUNIT.,'INCH',{measure})")
        radian = self.add("IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.)")
        degree_measure = self.add(
            f"IFCMEASUREWITHUNIT(IFCPLANEANGLEMEASURE({self.num(pi / 180)}),{radian})"
        )
        exponents = self.add("IFCDIMENSIONALEXPONENTS(0,0,0,0,0,0,0)")
        degree = self.add(
            f"IFCCONVERSIONBASEDUNIT({exponents},.PLANEANGLEUNIT.,'DEGREE',{degree_measure})"
        )
        self.world = self.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))
        self.context = self.add(
            f"IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05,{self.world},$)"
        )
        units = self.add(f"IFCUNITASSIGNMENT(({unit},{degree}))")
        self.add(f"IFCPROJECT('{self.guid()}',{self.owner},'P',$,$,$,$,({self.context}),{units})")

    def text(self, view: str = "CoordinationView") -> str:
        head = (
            "ISO-10303-21;\nHEADER;\n"
            f"FILE_DESCRIPTION(('ViewDefinition [{view}]'),'2;1');\n"
            "FILE_NAME('','2020-01-01T00:00:00',(''),(''),'','beamcam tests','');\n"
            f"FILE_SCHEMA(('{self.schema}'));\nENDSEC;\nDATA;\n"
        )
        return head + "\n".join(self.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"


class Writer:
    """One model in one encoding."""

    def __init__(self, encoding: str, random: Random) -> None:
        self.encoding, self.random = encoding, random
        self.guids: list[str] = []
        schema = {"csg": "IFC2X3", "openings": "IFC2X3", "brep": "IFC2X3"}.get(
            self.encoding, "IFC4"
        )
        if self.encoding in ("metre", "outline"):
            schema = "IFC4X3_ADD2"
        unit = {"inch": "inch", "metre": "metre"}.get(self.encoding, "mm")
        self.step = Step(schema, unit)

    def add(self, member: Member) -> str:
        """Write a member; its GlobalId."""
        step = self.step
        placement = step.add(f"IFCLOCALPLACEMENT($,{self._somewhere()})")
        guid = step.guid()
        openings: list[tuple[str, str]] = []
        if self.encoding in ("brep", "mesh"):
            item, kind = self._faceted(member)
        else:
            item, kind, openings = self._swept(member)
        shape = step.add(f"IFCSHAPEREPRESENTATION({step.context},'Body','{kind}',({item}))")
        if self.encoding == "mirrored":
            shape = self._mirrored(shape)
        product = step.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        last = "" if step.schema == "IFC2X3" else ",$"
        element = step.add(
            f"IFCBEAM('{guid}',{step.owner},'BEAM',$,$,{placement},{product},'{member.mark}'{last})"
        )
        for solid, position in openings:
            self._opening(element, placement, solid, position)
        self.guids.append(guid)
        return guid

    def _somewhere(self) -> str:
        r = self.random
        z = _unit((r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(0.1, 1)))
        x = _unit(_cross((0.3, 1.0, -0.2), z))
        return self.step.axes(
            (r.uniform(-1e5, 1e5), r.uniform(-1e5, 1e5), r.uniform(-1e4, 1e4)), z, x
        )

    def local(self, member: Member, p: Vec) -> Vec:
        """A point (x, Y, Z) of the member in the element: profile x is y, profile y is z."""
        at = lie(member.code, member.sizes)
        px = at.origin[0] + at.y[0] * p[1] + at.z[0] * p[2]
        py = at.origin[1] + at.y[1] * p[1] + at.z[1] * p[2]
        return (p[0] if at.forward else member.length - p[0], px, py)

    def vector(self, member: Member, v: Vec) -> Vec:
        a, b = self.local(member, (0, 0, 0)), self.local(member, v)
        return (b[0] - a[0], b[1] - a[1], b[2] - a[2])

    def _swept(self, member: Member) -> tuple[str, str, list[tuple[str, str]]]:
        step = self.step
        margin = 30.0
        profile = self._outline(member) if self.encoding == "outline" else self._profile(member)
        position = step.axes((-margin, 0, 0), (1, 0, 0), (0, 1, 0))
        up = step.direction(0, 0, 1)
        depth = step.length(member.length + 2 * margin)
        item = step.add(f"IFCEXTRUDEDAREASOLID({profile},{position},{up},{depth})")
        booleans = "IFCBOOLEANCLIPPINGRESULT"
        kind = "Clipping"
        openings = []
        for side, (a, b, c) in zip((-1, 1), planes(member), strict=True):
            outward = _unit(self.vector(member, (side, -side * a, -side * b)))
            through = self.local(member, (c, 0.0, 0.0))
            flag = self.random.random() < 0.5
            normal = tuple(-v for v in outward) if flag else outward
            across = _unit(_cross(normal, (0.21, 0.37, 0.9)))  # type: ignore[arg-type]
            plane = step.add(f"IFCPLANE({step.axes(through, normal, across)})")  # type: ignore[arg-type]
            half = step.add(f"IFCHALFSPACESOLID({plane},{'.T.' if flag else '.F.'})")
            item = step.add(f"{booleans}(.DIFFERENCE.,{item},{half})")
        for hole in member.holes:
            solid, position = self._drill(member, hole)
            if self.encoding in ("openings", "voiding"):
                openings.append((solid, position))
            else:
                item = step.add(f"IFCBOOLEANRESULT(.DIFFERENCE.,{item},{solid})")
                kind = "CSG"
        return item, kind, openings

    def _profile(self, member: Member) -> str:
        step = self.step
        h, b, tf, tw = (step.length(v) for v in member.sizes)
        at = step.add(
            f"IFCAXIS2PLACEMENT2D({step.add('IFCCARTESIANPOINT((0.,0.))')},{step.add('IFCDIRECTION((1.,0.))')})"
        )
        old = step.schema == "IFC2X3"
        match member.code:
            case "I":
                tail = "" if old else ",$,$"
                return step.add(f"IFCISHAPEPROFILEDEF(.AREA.,$,{at},{b},{h},{tw},{tf},$ {tail})")
            case "U":
                tail = "$,$,$,$" if old else "$,$,$"
                return step.add(f"IFCUSHAPEPROFILEDEF(.AREA.,$,{at},{h},{b},{tw},{tf},{tail})")
            case "L":
                tail = "$,$,$,$,$" if old else "$,$,$"
                return step.add(f"IFCLSHAPEPROFILEDEF(.AREA.,$,{at},{h},{b},{tw},{tail})")
            case "T":
                tail = "$,$,$,$,$,$" if old else "$,$,$,$,$"
                return step.add(f"IFCTSHAPEPROFILEDEF(.AREA.,$,{at},{b},{h},{tf},{tw},{tail})")
            case "M":
                return step.add(f"IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,{at},{b},{h},{tw},$,$)")
        return step.add(f"IFCRECTANGLEPROFILEDEF(.AREA.,$,{at},{b},{h})")

    def _outline(self, member: Member) -> str:
        """The section as an arbitrary outline, its inner corners rounded by arcs."""
        step = self.step
        rings = [section_polygon(member), bore_polygon(member)]
        curves = []
        for ring in rings:
            if ring:
                points = [self.local(member, (0.0, y, z))[1:] for y, z in ring]
                curves.append(self._rounded(points, 8.0 if member.code in "IULT" else 0.0))
        if len(curves) == 2:
            return step.add(f"IFCARBITRARYPROFILEDEFWITHVOIDS(.AREA.,$,{curves[0]},({curves[1]}))")
        return step.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{curves[0]})")

    def _rounded(self, points: Sequence[Pair], radius: float) -> str:
        """A composite curve of lines, with trimmed circles at the reflex corners."""
        step = self.step
        n = len(points)
        area = sum(
            points[i - 1][0] * points[i][1] - points[i - 1][1] * points[i][0] for i in range(n)
        )
        if area < 0:
            points = points[::-1]
        pieces, previous = [], None
        first = None
        for i, p in enumerate(points):
            before, after = points[i - 1], points[(i + 1) % n]
            d0 = _unit((p[0] - before[0], p[1] - before[1], 0.0))
            d1 = _unit((after[0] - p[0], after[1] - p[1], 0.0))
            reflex = d0[0] * d1[1] - d0[1] * d1[0] < 0
            enter, leave = p, p
            if reflex and radius:
                enter = (p[0] - d0[0] * radius, p[1] - d0[1] * radius)
                leave = (p[0] + d1[0] * radius, p[1] + d1[1] * radius)
            if previous is None:
                first = enter
            else:
                pieces.append(self._line(previous, enter))
            if reflex and radius:
                centre = (enter[0] + d0[1] * radius, enter[1] - d0[0] * radius)
                pieces.append(self._trimmed(centre, radius, enter, leave))
            previous = leave
        assert previous is not None
        assert first is not None
        pieces.append(self._line(previous, first))
        segments = [
            step.add(f"IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,{'.T.' if same else '.F.'},{curve})")
            for curve, same in pieces
        ]
        return step.add(f"IFCCOMPOSITECURVE(({','.join(segments)}),.F.)")

    def _line(self, a: Pair, b: Pair) -> tuple[str, bool]:
        same = self.random.random() < 0.5
        p, q = (a, b) if same else (b, a)
        return self.step.add(f"IFCPOLYLINE(({self.step.point(*p)},{self.step.point(*q)}))"), same

    def _trimmed(self, centre: Pair, radius: float, a: Pair, b: Pair) -> tuple[str, bool]:
        """A clockwise quarter from a to b, by angles in degrees or by points."""
        from math import atan2

        step = self.step
        at = step.add(f"IFCAXIS2PLACEMENT2D({step.point(*centre)},$)")
        circle = step.add(f"IFCCIRCLE({at},{step.length(radius)})")
        start, end = (degrees(atan2(p[1] - centre[1], p[0] - centre[0])) for p in (a, b))
        if self.random.random() < 0.5:
            trims = [f"IFCPARAMETERVALUE({step.num(v)})" for v in (start, end)]
            master = ".PARAMETER."
        else:
            trims = [step.point(*p) for p in (a, b)]
            master = ".CARTESIAN."
        if self.random.random() < 0.5:
            text = f"IFCTRIMMEDCURVE({circle},({trims[0]}),({trims[1]}),.F.,{master})"
            return step.add(text), True
        text = f"IFCTRIMMEDCURVE({circle},({trims[1]}),({trims[0]}),.T.,{master})"
        return step.add(text), False

    def _drill(self, member: Member, hole: HoleSpec) -> tuple[str, str]:
        """A cutter through a wall, or through the walls on both sides, and where it stands."""
        step = self.step
        mine = next(w for w in walls(member) if w.face == hole.face)
        extent = member.sizes[mine.normal - 1]
        low, high = (0.0, extent) if hole.both else (mine.low, mine.high)
        low, high = low - 3.0, high + 3.0
        axis = [0.0, 0.0, 0.0]
        axis[mine.normal] = 1.0
        start = [hole.x, hole.q, hole.q]
        start[mine.normal] = low
        o = self.local(member, (start[0], start[1], start[2]))
        z = _unit(self.vector(member, (axis[0], axis[1], axis[2])))
        along = [0.0, 0.0, 0.0]
        along[0 if hole.slot_along else 3 - mine.normal] = 1.0
        x = _unit(self.vector(member, (along[0], along[1], along[2])))
        at = step.add(
            f"IFCAXIS2PLACEMENT2D({step.add('IFCCARTESIANPOINT((0.,0.))')},{step.add('IFCDIRECTION((1.,0.))')})"
        )
        r = step.length(hole.diameter / 2)
        if hole.slot:
            size = step.length(hole.slot + hole.diameter), step.length(hole.diameter)
            profile = step.add(
                f"IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,{at},{size[0]},{size[1]},{r})"
            )
        else:
            profile = step.add(f"IFCCIRCLEPROFILEDEF(.AREA.,$,{at},{r})")
        up = step.direction(0, 0, 1)
        position = step.axes(o, z, x)
        inside = position
        if self.encoding in ("openings", "voiding"):
            inside = step.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))
        solid = step.add(f"IFCEXTRUDEDAREASOLID({profile},{inside},{up},{step.length(high - low)})")
        return solid, position

    def _opening(self, element: str, placement: str, solid: str, position: str) -> None:
        step = self.step
        here = step.add(f"IFCLOCALPLACEMENT({placement},{position})")
        shape = step.add(f"IFCSHAPEREPRESENTATION({step.context},'Body','SweptSolid',({solid}))")
        product = step.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        name = "IFCVOIDINGFEATURE" if self.encoding == "voiding" else "IFCOPENINGELEMENT"
        last = {"IFCVOIDINGFEATURE": ",.HOLE."}.get(name, "" if step.schema == "IFC2X3" else ",$")
        opening = step.add(
            f"{name}('{step.guid()}',{step.owner},'Bolt Hole',$,'BoltHole',{here},{product},$"
            f"{last})"
        )
        step.add(f"IFCRELVOIDSELEMENT('{step.guid()}',{step.owner},$,$,{element},{opening})")

    def _mirrored(self, shape: str) -> str:
        step = self.step
        source = step.add(
            f"IFCREPRESENTATIONMAP({step.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))},{shape})"
        )
        operator = step.add(
            f"IFCCARTESIANTRANSFORMATIONOPERATOR3D({step.direction(1, 0, 0)},"
            f"{step.direction(0, -1, 0)},"
            f"{step.point(0, 0, 0)},1.,{step.direction(0, 0, 1)})"
        )
        item = step.add(f"IFCMAPPEDITEM({source},{operator})")
        return step.add(
            f"IFCSHAPEREPRESENTATION({step.context},'Body','MappedRepresentation',({item}))"
        )

    def _faceted(self, member: Member) -> tuple[str, str]:
        faces = [
            [[self.local(member, p) for p in ring] for ring in face] for face in facets(member)
        ]
        step = self.step
        if self.encoding == "mesh":
            return self._polygons(faces), "Tessellation"
        made = []
        for face in faces:
            bounds = []
            for i, ring in enumerate(face):
                loop = step.add(f"IFCPOLYLOOP(({','.join(step.point(*p) for p in ring)}))")
                kind = "IFCFACEOUTERBOUND" if i == 0 else "IFCFACEBOUND"
                bounds.append(step.add(f"{kind}({loop},.T.)"))
            made.append(step.add(f"IFCFACE(({','.join(bounds)}))"))
        shell = step.add(f"IFCCLOSEDSHELL(({','.join(made)}))")
        return step.add(f"IFCFACETEDBREP({shell})"), "Brep"

    def _polygons(self, faces: list[list[list[Vec]]]) -> str:
        step = self.step
        points: dict[Vec, int] = {}
        texts = []
        for face in faces:
            rings = []
            for ring in face:
                rings.append([points.setdefault(p, len(points) + 1) for p in ring])
            outer = ",".join(map(str, rings[0]))
            if len(rings) == 1:
                texts.append(step.add(f"IFCINDEXEDPOLYGONALFACE(({outer}))"))
            else:
                inner = ",".join(f"({','.join(map(str, r))})" for r in rings[1:])
                texts.append(step.add(f"IFCINDEXEDPOLYGONALFACEWITHVOIDS(({outer}),({inner}))"))
        listed = ",".join(f"({','.join(step.length(v) for v in p)})" for p in points)
        last = ",$" if step.schema == "IFC4X3_ADD2" else ""
        where = step.add(f"IFCCARTESIANPOINTLIST3D(({listed}){last})")
        return step.add(f"IFCPOLYGONALFACESET({where},.T.,({','.join(texts)}),$)")


def facets(member: Member) -> list[list[list[Vec]]]:
    """Faces of the member in (x, Y, Z): sides, ends, and holes as polygons on their circle."""
    (a0, b0, c0), (a1, b1, c1) = planes(member)

    def start(y: float, z: float) -> Vec:
        return (a0 * y + b0 * z + c0, y, z)

    def end(y: float, z: float) -> Vec:
        return (a1 * y + b1 * z + c1, y, z)

    outer, bore = section_polygon(member), bore_polygon(member)
    faces: list[list[list[Vec]]] = []
    sides: list[tuple[Pair, Pair, list[list[Vec]]]] = []
    for ring in (outer, bore):
        for i, p in enumerate(ring):
            q = ring[i - 1]
            face = [[start(*q), end(*q), end(*p), start(*p)]]
            sides.append((q, p, face))
            faces.append(face)
    for at in (start, end):
        cap = [[at(*p) for p in outer]]
        if bore:
            cap.append([at(*p) for p in bore])
        faces.append(cap)
    for hole in member.holes:
        mine = [w for w in walls(member) if w.face == hole.face]
        if hole.both:
            mine += [w for w in walls(member) if w.face == {"o": "u", "v": "h"}[hole.face]]
        for wall in mine:
            loops = []
            for c in (wall.low, wall.high):
                loop = _polygon(member, hole, wall, c)
                loops.append(loop)
                for q, p, face in sides:
                    k, other = wall.normal - 1, 2 - wall.normal
                    inside = min(q[other], p[other]) < hole.q < max(q[other], p[other])
                    if abs(q[k] - c) < 1e-9 and abs(p[k] - c) < 1e-9 and inside:
                        face.append(loop)
            for i in range(len(loops[0])):
                faces.append([[loops[0][i - 1], loops[0][i], loops[1][i], loops[1][i - 1]]])
    return turned_alike(faces)


def turned_alike(faces: list[list[list[Vec]]]) -> list[list[list[Vec]]]:
    """The faces turned so that every edge is run through once in each direction."""
    for face in faces:
        outward = _newell(face[0])
        for i in range(1, len(face)):
            if sum(a * b for a, b in zip(_newell(face[i]), outward, strict=True)) > 0:
                face[i] = face[i][::-1]
    at: dict[tuple[Vec, Vec], list[int]] = {}
    for k, face in enumerate(faces):
        for a, b in _edges(face):
            at.setdefault((min(a, b), max(a, b)), []).append(k)
    done, todo = {0}, [0]
    while todo:
        k = todo.pop()
        mine = set(_edges(faces[k]))
        for a, b in mine:
            for other in at[min(a, b), max(a, b)]:
                if other in done:
                    continue
                if (a, b) in _edges(faces[other]):
                    faces[other] = [ring[::-1] for ring in faces[other]]
                done.add(other)
                todo.append(other)
    assert len(done) == len(faces)
    return faces


def _edges(face: list[list[Vec]]) -> list[tuple[Vec, Vec]]:
    return [(ring[i - 1], p) for ring in face for i, p in enumerate(ring)]


def _newell(ring: list[Vec]) -> Vec:
    x = y = z = 0.0
    for i, p in enumerate(ring):
        c = _cross(ring[i - 1], p)
        x, y, z = x + c[0], y + c[1], z + c[2]
    return (x, y, z)


def _polygon(member: Member, hole: HoleSpec, wall: WallSpec, c: float) -> list[Vec]:
    out: list[Vec] = []
    for i in range(member.corners):
        angle = 2 * pi * (i + 0.3) / member.corners
        x, q = hole.x + hole.diameter / 2 * cos(angle), hole.q + hole.diameter / 2 * sin(angle)
        out.append((x, c, q) if wall.normal == 1 else (x, q, c))
    return out


def model_text(members: Sequence[Member], encoding: str, random: Random) -> tuple[str, list[str]]:
    """A model of members in one encoding, and their GlobalIds."""
    writer = Writer(encoding, random)
    for member in members:
        writer.add(member)
    return writer.step.text(), writer.guids


def _cross(a: Vec, b: Vec) -> Vec:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _unit(v: Vec) -> Vec:
    by = sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    return (v[0] / by, v[1] / by, v[2] / by)


def slope_deg(a: float) -> float:
    return -degrees(atan(a))
