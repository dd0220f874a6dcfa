"""What one part needs done, wherever it comes to lie on a bar.

features -> refused, or left out where that is allowed
         -> holes: duplicates dropped, flange pairs merged, a recipe for each
         -> slots: ends drilled, then milled      -> lines: scribed
"""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.geometry.plane import Point, unit_vector
from beamcam.machine.machine import Drill, Machine, Saw
from beamcam.model.part import Contour, Face, Feature, Hole, Part, Slot
from beamcam.model.plan import FeatureRef
from beamcam.planning import rules
from beamcam.planning.bar import Ends, refuse_cut
from beamcam.planning.ends import End, ends_of
from beamcam.planning.holes import Refusal, Step, recipe
from beamcam.planning.merging import Group, Placed, drop_duplicates, merge_pairs
from beamcam.planning.paths import line_points, pocket_path
from beamcam.planning.refuse import (
    clear_between,
    face_at_work,
    faces_at_work,
    refuse_other,
    refuse_place,
    refuse_slot,
)
from beamcam.planning.strokes import fixed_faces, refuse_strokes
from beamcam.planning.tools import Rack, Tools

SQUARE: Ends = (End("start", 0.0, 0.0), End("end", 0.0, 0.0))


class Job(NamedTuple):
    """One operation of a spindle, at its place on the part.

    A tuple, because a part has hundreds of them and they are made in half the time.
    """

    x: float
    y: float
    spindle: int
    tools: Tools  #: any of which may do it
    faces: tuple[Face, ...]
    depth: float | None
    diameter: float  #: of the hole; 0 where the tool does not follow from it
    features: tuple[int, ...]  #: those of the part that it makes
    reasons: tuple[str, ...]
    source: Source
    path: tuple[Point, ...] = ()  #: x on the part and y on the face; () for a stroke


class Work(Struct, frozen=True):
    """What one part needs done, and what of it cannot be."""

    ends: Ends
    jobs: tuple[Job, ...]
    skipped: dict[int, Diagnostic]  #: features left out by leave, and why
    repeats: dict[int, int]  #: duplicates, and the feature that makes each
    refusals: tuple[Diagnostic, ...]
    remarks: tuple[Diagnostic, ...]


def work_on(part: Part, machine: Machine, saw: Saw, rack: Rack, skips: Collection[str]) -> Work:
    """What `part` needs done as it lies; refusals are in the result, and not raised."""
    try:
        ends, remarks = ends_of(part, saw.least_mitre)
    except PlanError as error:
        return Work(SQUARE, (), {}, {}, error.diagnostics, ())
    refusals = [said for end in ends if (said := refuse_cut(end, saw, part.source))]
    bench = _Bench(part, machine, rack)
    holes = bench.sort_features(ends)
    kept, dropped = drop_duplicates(holes, rack.drill.duplicate_tolerance)
    bench.add_holes(kept)
    if fixed_faces(machine):
        bench.refuse_strokes()
    refused = bench.refused
    repeats = {f: ref[1] for (_, f), (ref, _) in dropped.items()}
    if repeats:
        remarks = (*remarks, *_duplicate_remarks(part, dropped))
        # What repeats a hole that cannot be made cannot be made either.
        refused |= {f: refused[first] for f, first in repeats.items() if first in refused}
        repeats = {f: first for f, first in repeats.items() if first not in refused}
    skipped = {f: said for f, said in refused.items() if said.code.removeprefix("plan-") in skips}
    refusals += [refused[f] for f in sorted(refused) if f not in skipped]
    return Work(ends, tuple(bench.jobs), skipped, repeats, tuple(refusals), remarks)


def _duplicate_remarks(part: Part, dropped: dict[FeatureRef, Placed]) -> Iterator[Diagnostic]:
    for (_, f), (_, first) in dropped.items():
        hole = part.features[f]
        if isinstance(hole, Hole):
            yield rules.DUPLICATE.at(
                hole.source, found=f"{hole.diameter:g}", face=hole.face, x=f"{hole.x:g}",
                y=f"{hole.y:g}", first=first.source,
            )  # fmt: skip


class _Bench:
    """One part on one machine: takes its features, collects the jobs and what is refused."""

    def __init__(self, part: Part, machine: Machine, rack: Rack) -> None:
        self.part, self.machine, self.rack = part, machine, rack
        self.jobs: list[Job] = []
        self.refused: dict[int, Diagnostic] = {}
        self._spindles: dict[Face, int] = {s.face: s.number for s in machine.spindles}
        self._reached = faces_at_work(machine, part.profile)
        self._behind: set[int] = set()  #: features that are made from the other side
        self._places: dict[int, Point] = {}  #: where a hole is made, which a merge may move

    def sort_features(self, ends: Ends) -> list[Placed]:
        """The holes that a spindle reaches; all other features become jobs or refusals."""
        holes: list[Placed] = []
        length, profile = self.part.length, self.part.profile
        width = {face: profile.face_width(face) for face in self._reached}
        clear = {face: clear_between(profile, face) for face in self._reached}
        for f, feature in enumerate(self.part.features):
            if feature.__class__ is not Hole:
                self._add_other(f, feature, ends)
                continue
            hole = feature
            assert isinstance(hole, Hole)
            if hole.face not in width:
                hole = self._from_behind(f, hole)
            face, y, radius = hole.face, hole.y, hole.diameter / 2
            if (
                face in width
                and 0 <= hole.x <= length
                and 0 <= y <= width[face]
                and clear[face][0] <= y - radius
                and y + radius <= clear[face][1]
            ):
                holes.append(((0, f), hole))
            else:
                self._refuse(f, refuse_place(hole, face, self.part, self._reached))
        return holes

    def _refuse(self, f: int, said: Diagnostic | None) -> bool:
        if said is not None:
            self.refused[f] = said
        return said is not None

    def _from_behind(self, f: int, hole: Hole) -> Hole:
        through = hole.depth is None and hole.kind == "through"
        face = face_at_work(hole.face, through, self.part.profile, self._reached)
        if face == hole.face:
            return hole
        self._behind.add(f)
        return replace(hole, face=face)

    def _add_other(self, f: int, feature: Feature, ends: Ends) -> None:
        if isinstance(feature, Slot):
            through = feature.depth is None and feature.kind == "through"
            face = face_at_work(feature.face, through, self.part.profile, self._reached)
            said = refuse_slot(feature, face, self.rack) or _refuse_slot_place(
                feature, face, self.part, self._reached
            )
            if not self._refuse(f, said):
                self.jobs += _slot_jobs(f, feature, face, self._spindles[face], self.rack)
        else:
            said = refuse_other(feature, self.part, ends, self.rack, self._reached)
            if self._refuse(f, said):
                return
            if isinstance(feature, Contour) and feature.process != "cut":
                spindle = self._spindles[feature.face]
                self.jobs.append(_scribe_job(f, feature, spindle, self.rack))

    def add_holes(self, holes: Sequence[Placed]) -> None:
        """The jobs of all holes, each once and in order along the part."""
        sinks: list[Group] = []
        known = self.rack.jobs
        for group in merge_pairs(holes, self.machine, self.rack.drill):
            hole = group[0][1]
            if hole.kind == "countersink":
                sinks.append(group)
                continue
            if hole.kind != "through" or self._behind:
                self._add_group(group, None)
                continue
            # Most holes are like one before, of this part or another, but for their place.
            key = hole.face, hole.diameter, group[1][1].diameter if len(group) == 2 else None
            like = known.get(key)
            if isinstance(like, Job):
                self.jobs.append(self._at(like, group))
                continue
            count = len(self.jobs)
            self._add_group(group, None)
            if len(self.jobs) == count + 1 and not self.jobs[count].path:
                known.keep(key, self.jobs[count])
        if sinks:
            pilots = _pilots(holes, self.rack.drill)
            for group in sinks:
                self._add_sink(group, [pilots.get(ref[1]) for ref, _ in group])

    def _at(self, like: Job, group: Group) -> Job:
        """The job of a plain hole or pair that is `like` another one."""
        (_, f), hole = group[0]
        x, y = hole.x, hole.y
        features: tuple[int, ...] = (f,)
        if len(group) == 2:
            (_, other_f), other = group[1]
            x, y, features = (x + other.x) / 2, (y + other.y) / 2, (f, other_f)
            self._places[other_f] = x, y
        self._places[f] = x, y
        _, _, spindle, tools, faces, depth, diameter, _, reasons, _, _ = like
        return Job(x, y, spindle, tools, faces, depth, diameter, features, reasons, hole.source, ())

    def _add_sink(self, group: Group, pilots: Sequence[Placed | None]) -> None:
        """The job of a countersink; of a pair one by one if they sink different holes."""
        made = [p[1].diameter if p and p[0][1] not in self.refused else None for p in pilots]
        if len(set(made)) == 1:
            self._add_group(group, pilots[0] if made[0] is not None else None)
        else:
            for placed, pilot, size in zip(group, pilots, made, strict=True):
                self._add_group((placed,), pilot if size is not None else None)

    def _add_group(self, group: Group, pilot: Placed | None) -> None:
        """The jobs of a hole or a pair; a pair for which there is no tool is made one by one."""
        (_, f), hole = group[0]
        faces: tuple[Face, ...] = (hole.face,)
        diameters: tuple[float, ...] = (hole.diameter,)
        features: tuple[int, ...] = (f,)
        why: tuple[str, ...] = ()
        x, y = hole.x, hole.y
        if len(group) == 2:
            (_, other_f), other = group[1]
            faces, features, why = (hole.face, other.face), (f, other_f), ("merge-pair",)
            x, y = (x + other.x) / 2, (y + other.y) / 2
            if other.diameter != hole.diameter:
                diameters = (hole.diameter, other.diameter)
        if pilot is not None:
            # A sink stands on its hole, wherever a merge has put that one.
            x, y = self._places[pilot[0][1]]
        steps = recipe(
            self.rack, hole.kind, diameters, hole.depth, hole.angle, faces,
            self.part.profile.thickness(hole.face), pilot[1].diameter if pilot else None,
        )  # fmt: skip
        if isinstance(steps, Refusal):
            if len(group) == 2:
                self._add_group((group[0],), pilot)
                self._add_group((group[1],), pilot)
            else:
                values = {"x": f"{x:g}", "y": f"{y:g}", **steps.values}
                self._refuse(f, steps.rule.at(hole.source, **values))
            return
        if f in self._behind:
            why = (*why, "from-behind")
        for feature in features:
            self._places[feature] = x, y
        number = self._number(faces)
        for step in steps:
            size = 0.0 if step.reason else diameters[0]
            reasons = (step.reason, *why) if step.reason else why
            path = self._ring(step, x, y) if step.ring else ()
            self.jobs.append(
                Job(
                    x, y, number, step.tools, faces, step.depth, size, features, reasons,
                    hole.source, path,
                )
            )  # fmt: skip

    def refuse_strokes(self) -> None:
        """Drop the jobs whose stroke is the machine's own and does not fit, and all beside them."""
        for job in self.jobs:
            self.refused |= refuse_strokes(
                self.part, self.machine, self.rack.drill, (job.x, job.y), job.tools, job.faces,
                job.depth, job.features,
            )  # fmt: skip
        self.jobs = [job for job in self.jobs if self.refused.keys().isdisjoint(job.features)]

    def _number(self, faces: tuple[Face, ...]) -> int:
        if len(faces) == 1:
            return self._spindles[faces[0]]
        return next(p.number for p in self.machine.pairs if set(p.faces) == set(faces))

    def _ring(self, step: Step, x: float, y: float) -> tuple[Point, ...]:
        mill, tolerance = step.tools[0].diameter, self.rack.drill.path_tolerance
        is_blind = step.depth is not None
        return pocket_path((x, y), (0.0, 0.0), 0.0, step.ring, mill, tolerance, is_blind)


def _pilots(holes: Sequence[Placed], drill: Drill) -> dict[int, Placed]:
    """For each countersink the hole that it sinks: of its face and place, the widest below it."""
    pilots = {}
    limit = drill.merge_tolerance
    for (_, f), sink in holes:
        if sink.kind != "countersink":
            continue
        below = [
            (hole.diameter, placed)
            for placed in holes
            for hole in (placed[1],)
            if hole.kind in ("through", "blind", "thread", "left-thread")
            and hole.face == sink.face
            and abs(hole.x - sink.x) <= limit
            and abs(hole.y - sink.y) <= limit
            and hole.diameter < sink.diameter
        ]
        if below:
            pilots[f] = max(below, key=lambda b: (b[0], b[1][0]))[1]
    return pilots


def slot_ends(slot: Slot) -> tuple[Point, ...]:
    """Centres of the corner circles of a slot: two, or four of a rectangle."""
    c, s = unit_vector(slot.angle)
    halves = dict.fromkeys(
        (k * slot.length / 2, m * slot.height / 2) for k in (-1, 1) for m in (-1, 1)
    )
    return tuple((slot.x + c * a - s * b, slot.y + s * a + c * b) for a, b in halves)


def _refuse_slot_place(
    slot: Slot, face: Face, part: Part, reached: Sequence[Face]
) -> Diagnostic | None:
    places = ((slot.x, slot.y), *slot_ends(slot))
    said = (refuse_place(replace(slot, x=x, y=y), face, part, reached) for x, y in places)
    return next((d for d in said if d is not None), None)


def _slot_jobs(f: int, slot: Slot, face: Face, spindle: int, rack: Rack) -> Iterator[Job]:
    """The ends drilled, where the machine does so and has the drill, and the slot milled."""
    ends = slot_ends(slot)
    faces = (face,)
    drills = rack.drills((slot.diameter,), faces)
    mill = rack.slot_mill(slot.diameter, faces)
    if rack.drill.slots == "drill-mill" and drills and len(ends) <= 2:
        for x, y in ends:
            yield Job(
                x, y, spindle, drills, faces, slot.depth, 0.0, (f,), ("slot-end",), slot.source
            )
    path = pocket_path(
        (slot.x, slot.y), (slot.length, slot.height), slot.angle, slot.diameter,
        mill[0].diameter, rack.drill.path_tolerance, slot.depth is not None,
    )  # fmt: skip
    x, y = path[0]
    yield Job(x, y, spindle, mill, faces, slot.depth, 0.0, (f,), ("slot-mill",), slot.source, path)


def _scribe_job(f: int, line: Contour, spindle: int, rack: Rack) -> Job:
    """A line scribed, from that end of it that comes first along the bar."""
    path = line_points(line.curves, rack.drill.path_tolerance)
    if path[-1][0] < path[0][0]:
        path = path[::-1]
    scribe = rack.of_kind("scribe", (line.face,))[:1]
    x, y = path[0]
    return Job(
        x, y, spindle, scribe, (line.face,), rack.drill.mark_depth, 0.0, (f,), ("scribe-line",),
        line.source, path,
    )  # fmt: skip
