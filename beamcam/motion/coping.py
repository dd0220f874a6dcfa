"""A plan of a coper put in motion: where the torch's tip goes, cut by cut.

    o                The torch travels on planes `clearance` outside of the bar's box, one for
 ______              each of the angles that it cuts at, and turns at their corners.
|      | v           X counts from the bar's leading end, Y and Z are those of the section.
|______|
    u
"""

from collections.abc import Iterator
from itertools import pairwise
from math import acos, ceil, cos, degrees, dist, hypot, radians, sin

from beamcam.machine.coper import A_OF_FACE, TUBES, Coper, torch_way
from beamcam.machine.machine import Machine
from beamcam.model.part import Face, part_data
from beamcam.model.plan import CopeCut, CopePlan, WorkTime
from beamcam.model.program import (
    Command,
    Comment,
    Program,
    StartProfile,
    ToolOff,
    ToolOn,
    TorchRound,
    TorchTo,
    TurnTorch,
)
from beamcam.model.surface import Patch, around, patch_of, surface_of

Place = tuple[float, float, float]

CHORD = 0.01  #: mm that the tip leaves the surface between two places of a corner
LEAST = 1e-6  #: mm; a shorter stretch is none
NAMES: dict[str, str] = {"inner": "cut-out", "notch": "notch", "near": "near end", "far": "far end"}


#: How sections lie that are turned about their length.
LIES = {
    "T": "THE T LIES ON ITS SIDE: FACE H AT Y 0, FACE U UP",
    "C": "THE C LIES ON ITS LIPS: FACE O AT Y 0, FACE H UP",
}


def coping_program(plan: CopePlan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    coper = machine.needed(machine.coper, "coper")
    torch = _Torch(plan, coper) if coper.turns == "torch" else _Bar(plan, coper)
    commands: list[Command] = [StartProfile(plan.profile.height, plan.profile.width)]
    # What the operator has to know of a bar or a piece as it is put in.
    turned, turns = LIES.get(plan.profile.code), coper.turns == "bar"
    texts: list[str] = []
    if turned is not None:
        texts.append(turned.replace("AT Y 0", "TO Y-") if turns else turned)
    if plan.usual_corners:
        radius = f"{plan.profile.radius:g}"
        texts.append(f"CORNERS OF {radius} MM OUTSIDE BY THE MACHINES TABLE: MEASURE ONE")
    is_tube = plan.profile.code in TUBES
    comes_cut = any(piece.part.made is not None for piece in plan.pieces)
    if turns and turned is None and (comes_cut or not is_tube):  # else it may lie as it likes
        up = "FACE U IS UP, FACE V TO Y+" if coper.a_unit == "mm" else "FACE V IS UP, FACE U TO Y-"
        texts.append(f"AT A 0 {up}")
    if turns and not is_tube:
        texts.append("IT TURNS ABOUT THE MIDDLE OF HEIGHT AND WIDTH")
    for piece in plan.pieces:
        if piece.part.made is not None:
            lies = "" if turned is not None or turns else ", FACE V UP, FACE U AT Y 0"
            texts.append(f"COMES CUT: ITS X 0 END AT X {piece.start:g}{lies}")
            if turns:
                held = piece.start + piece.part.length - coper.chuck
                texts.append(f"THE CHUCK HOLDS IT BEHIND X {held:g}")
            texts.append("WHAT ITS FILE CALLS MADE IS THERE")
    commands += map(Comment, texts)
    for cut in plan.operations:
        commands += torch.make(cut)
    commands += torch.home()
    return Program(job, tuple(commands), part_data([piece.part for piece in plan.pieces]))


#: mm of a block of inverse time; the figure of a shorter one would have more digits than are read.
SHORTEST = 0.001


class _Torch:
    """The torch and where it is."""

    def __init__(self, plan: CopePlan, coper: Coper) -> None:
        profile = plan.profile
        self._coper, self._start = coper, plan.pieces[0].start
        self._patches = surface_of(profile)
        self._top = profile.width + coper.clearance
        self._sides = {"o": profile.height + coper.clearance, "u": -coper.clearance}
        self._face: Face | None = None
        self._a_deg = self._b_deg = 0.0
        self._at: Place = (0.0, 0.0, 0.0)

    def make(self, cut: CopeCut) -> Iterator[Command]:
        """The commands of a cut, from where the torch stands outside of the bar's box."""
        patch = patch_of(self._patches, cut.face)
        assert patch is not None, cut.face
        row = cut.row
        turns = cut.turns or ((cut.a_off_deg, cut.b_deg),) * len(cut.path)
        turns = tuple((A_OF_FACE[cut.face] + off, b_deg) for off, b_deg in turns)
        pierce = self._tip(patch, cut.path[0], self._away(patch, row.pierce_height, turns[0]))
        away = {turn: self._away(patch, row.cut_height, turn) for turn in {*turns}}
        yield Comment(_name_of(cut))
        yield from self._approach(cut.face, pierce)
        yield from self._turned(self._at, cut.face, turns[0])
        yield self._to(pierce, True)
        yield ToolOn(
            row.process, row.feed_mm_min, row.power, row.pierce_s, cut.source, row.pierce_height,
            row.cut_height,
        )  # fmt: skip
        yield self._to(self._tip(patch, cut.path[0], away[turns[0]]), False)
        for (before, place), turn in zip(pairwise(cut.path), turns[1:], strict=True):
            tip = self._tip(patch, place, away[turn])
            if cut.turns:
                (self._a_deg, self._b_deg), self._at = turn, tip
                x, y, z = self._programmed(tip, *turn)
                per_minute = row.feed_mm_min / max(dist(before, place), SHORTEST)
                yield TorchRound(x, y, z, turn[0], per_minute, turn[1])
            else:
                yield self._to(tip, False)
        yield ToolOff(row.process)
        yield self._to(self._outside(cut.face, self._at), True)
        yield from self._turned(self._at, cut.face)

    def home(self) -> Iterator[Command]:
        """The commands that leave the torch upright, above the bar."""
        if self._face not in (None, "v"):
            yield from self._approach("v", self._at)

    def _approach(self, face: Face, place: Place) -> Iterator[Command]:
        """The commands to where a place of a face is reached along the torch.

        A program begins with the torch upright above the bar. It turns at a corner of the box.
        """
        x, y, _ = place
        if self._face is None:
            above = x, y, self._top
            yield from self._turned(above, "v")
            yield self._to(above, True)
        if face != self._face:
            steps: list[Face] = ["v"] if "v" not in (face, self._face) else []
            for step in (*steps, face):
                side = self._face if step == "v" else step
                assert side is not None
                corner = self._at[0], self._sides[side], self._top
                if self._at != corner:
                    yield self._to(corner, True)
                yield from self._turned(corner, step)
        outside = self._outside(face, place)
        if outside != self._at:
            yield self._to(outside, True)

    def _outside(self, face: Face, place: Place) -> Place:
        """Where the torch stands over a place, outside of the bar's box."""
        x, y, z = place
        return (x, y, self._top) if face == "v" else (x, self._sides[face], z)

    def _tip(self, patch: Patch, place: tuple[float, float], away: Place) -> Place:
        """The tip as it points at a place of a face, so far away from it."""
        x, y, z = patch.point(place[0] + self._start, place[1])
        return x + away[0], y + away[1], z + away[2]

    def _away(self, patch: Patch, height: float, turn: tuple[float, float]) -> Place:
        """The way from a place of a flat wall to the tip, at a height of the row over it."""
        off = radians(turn[0] - patch.a_deg(0.0))
        leaning = degrees(acos(min(1.0, cos(off) * cos(radians(turn[1])))))
        return _along((0.0, 0.0, 0.0), self._coper.standoff(height, leaning), *turn)

    def _programmed(self, tip: Place, a_deg: float, b_deg: float) -> Place:
        """What a program says of a tip: the tip itself, or the axes that the torch turns about."""
        return tip if self._coper.tcp else _along(tip, self._coper.pivot, a_deg, b_deg)

    def _to(self, tip: Place, rapid: bool) -> Command:
        assert self._face is not None
        self._at = tip
        return TorchTo(*self._programmed(tip, self._a_deg, self._b_deg), rapid)

    def _turned(
        self, tip: Place, face: Face, turn: tuple[float, float] | None = None
    ) -> Iterator[Command]:
        """The turn to a face, or off it, and a tilt, the tip at a place; nothing where it has both.

        An axis that goes straight while the torch turns takes the tip off that place by
        pivot (1 - cos(step / 2)); steps are so small that this is a quarter of the clearance.
        """
        last, b_deg = turn or (A_OF_FACE[face], 0.0)
        first = last if self._face is None else self._a_deg
        if self._face == face and (first, self._b_deg) == (last, b_deg):
            return
        tilted, self._b_deg, self._a_deg = self._b_deg, b_deg, last
        steps = 1
        if not self._coper.tcp:
            off = min(1.0, self._coper.clearance / 4 / self._coper.pivot)
            most = max(abs(last - first), abs(b_deg - tilted))
            steps = ceil(most / degrees(2 * acos(1 - off))) or 1
        self._at, self._face = tip, face
        for k in range(1, steps + 1):
            a_deg, b = first + (last - first) * k / steps, tilted + (b_deg - tilted) * k / steps
            yield TurnTorch(*self._programmed(tip, a_deg, b), a_deg, b)


def _name_of(cut: CopeCut) -> str:
    through = ", through the root" if cut.root else ", through the lip" if cut.lip else ""
    what = f"{NAMES[cut.kind]} on face {cut.face}{through}"
    if cut.bevel and cut.kind == "notch":
        what = f"an edge of face {cut.face}"
    return f"{'lower ' if cut.lower else ''}bevel of {what}" if cut.bevel else what


def _along(place: Place, far: float, a_deg: float, b_deg: float) -> Place:
    """The place that lies so far from one along the torch, towards its head."""
    x, y, z = torch_way(a_deg, b_deg)
    return place[0] + far * x, place[1] + far * y, place[2] + far * z


class _Bar:
    """A torch that stands upright over a bar, which turns below it about Y 0, Z 0.

    A tube turns as its surface passes below the torch. Of any other profile the middle of height
    and width lies on that axis; it turns between cuts, so that the wall to be cut lies flat.
    """

    def __init__(self, plan: CopePlan, coper: Coper) -> None:
        profile = plan.profile
        self._coper, self._start, self._profile = coper, plan.pieces[0].start, profile
        self._way = around(profile) if profile.code in TUBES else None
        self._patches = surface_of(profile)
        far = self._way.half_diagonal if self._way else hypot(profile.height, profile.width) / 2
        self._over = far + coper.clearance
        self._a_deg: float | None = None

    def make(self, cut: CopeCut) -> Iterator[Command]:
        """The commands of a cut, from where the torch stands clear of the bar as it turns.

        A block takes as long as its way on the surface does at the feed of the row.
        """
        row, face = cut.row, cut.face
        x, y, z, a_deg = self._pose(face, cut.path[0], row.pierce_height)
        yield Comment(NAMES[cut.kind] if self._way else _name_of(cut))
        yield TorchTo(x, y, self._over, True)
        if a_deg != self._a_deg:
            yield TurnTorch(x, y, self._over, a_deg)
        yield TorchTo(x, y, z, True)
        yield ToolOn(
            row.process, row.feed_mm_min, row.power, row.pierce_s, cut.source, row.pierce_height,
            row.cut_height,
        )  # fmt: skip
        down = row.pierce_height - row.cut_height
        if down > 0.0:
            yield TorchRound(*self._pose(face, cut.path[0], row.cut_height), row.feed_mm_min / down)
        last = cut.path[0]
        for before, place in pairwise(cut.path):
            for b in self._blocks(before, place):
                way = dist(last, b)
                if way >= SHORTEST:
                    yield TorchRound(*self._pose(face, b, row.cut_height), row.feed_mm_min / way)
                    last = b
        yield ToolOff(row.process)
        x, y, _, self._a_deg = self._pose(face, cut.path[-1], 0.0)
        yield TorchTo(x, y, self._over, True)

    def home(self) -> Iterator[Command]:
        """Nothing: the torch stands clear of the bar."""
        return iter(())

    def _pose(
        self, face: Face, place: tuple[float, float], height: float
    ) -> tuple[float, float, float, float]:
        """X, Y and Z of the tip so high over a place of a face, and A at which that is on top."""
        x, u = place
        if self._way is not None:
            a_deg, y, z = self._way.pose(u)
            return x + self._start, y, z + height, u if self._coper.a_unit == "mm" else a_deg
        patch = patch_of(self._patches, face)
        assert patch is not None, face
        _, y, z = patch.point(0.0, u)
        y, z, a_deg = y - self._profile.height / 2, z - self._profile.width / 2, A_OF_FACE[face]
        c, s = cos(radians(a_deg)), sin(radians(a_deg))
        return x + self._start, c * y + s * z, c * z - s * y + height, a_deg

    def _blocks(
        self, a: tuple[float, float], b: tuple[float, float]
    ) -> Iterator[tuple[float, float]]:
        """Places behind one of the surface up to another, such that axes go straight between them.

        A stretch ends where a face or a corner does, and on a corner it is short.
        """
        if self._way is not None and len(self._way.legs) > 1 and a[1] != b[1]:
            rises = a[1] < b[1]
            low, high = (a[1], b[1]) if rises else (b[1], a[1])
            between: list[float] = []
            s = low
            while s < high - LEAST:
                end, step = self._way.longest(s, CHORD)
                way = min(end, high) - s
                count = ceil(way / step) or 1  # without a limit it is one step
                between += [s + way * k / count for k in range(1, count + 1)]
                s = between[-1]
            for s in between if rises else reversed(between):
                if low + LEAST < s < high - LEAST:
                    share = (s - a[1]) / (b[1] - a[1])
                    yield a[0] + share * (b[0] - a[0]), s
        yield b


def coping_time(plan: CopePlan, program: Program, machine: Machine) -> WorkTime:
    """How long each cut takes, its travels and turns before it included, and the way back."""
    speeds: dict[str, float] = {axis.moves: axis.speed for axis in machine.axes}
    seconds: list[float] = []
    spent, feed = 0.0, 1.0
    at: Place | None = None
    a_deg: float | None = None
    b_deg = 0.0
    for command in program.commands:
        match command:
            case TurnTorch(x, y, z, turned, tilted):
                if a_deg is not None:
                    spent += max(
                        abs(turned - a_deg) / speeds.get("A", 90.0),
                        abs(tilted - b_deg) / speeds.get("B", 90.0),
                    )
                a_deg, b_deg, at = turned, tilted, (x, y, z)
            case TorchTo(x, y, z, rapid):
                if at is not None and rapid:
                    ways = zip("XYZ", at, (x, y, z), strict=True)
                    spent += max(abs(b - a) / speeds.get(axis, 250.0) for axis, a, b in ways)
                elif at is not None:
                    spent += 60.0 * dist(at, (x, y, z)) / feed
                at = x, y, z
            case TorchRound():
                spent += 60.0 / command.per_minute
                at, a_deg = (command.x, command.y, command.z), command.a_deg
                b_deg = command.b_deg or 0.0
            case ToolOn():
                spent, feed = spent + command.pierce_s, command.feed_mm_min
            case ToolOff():
                seconds.append(spent)
                spent = 0.0
    return WorkTime(tuple(seconds), home_s=spent)
