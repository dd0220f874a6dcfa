"""What one part needs done, wherever it comes to lie on a bar.

features -> refused, or left out where that is allowed
         -> holes: duplicates dropped, flange pairs merged, a recipe for each
         -> slots: ends drilled, then milled      -> lines: scribed
"""

from collections.abc import Collection, Iterable, Iterator, Sequence

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Severity
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Drill, Machine, Saw
from beamcam.model.part import Contour, Face, Feature, Hole, Part, Slot
from beamcam.planning import rules
from beamcam.planning.bar import Ends, refuse_cut
from beamcam.planning.ends import End, ends_of
from beamcam.planning.holes import Refusal, Step, recipe
from beamcam.planning.jobs import Job, Tooling, scribe_job, slot_ends, slot_jobs
from beamcam.planning.limits import refuse_beyond, turning_saw
from beamcam.planning.merging import Group, Placed, drop_duplicates, merge_pairs, partner_faces
from beamcam.planning.operations import rules as finished_rules
from beamcam.planning.operations.hole import FinishedPart, judge_point
from beamcam.planning.operations.hole_pairs import judge_pairs, named
from beamcam.planning.operations.saw_cut import judge_ends
from beamcam.planning.operations.slot_pairs import Shape, judge_slots
from beamcam.planning.paths import pocket_path
from beamcam.planning.refuse import (
    face_at_work,
    reach_of,
    refuse_other,
    refuse_place,
    refuse_slot,
    refuse_too_near,
)
from beamcam.planning.strokes import fixed_faces, refuse_strokes
from beamcam.planning.tools import Rack

SQUARE: Ends = (End("start", 0.0, 0.0), End("end", 0.0, 0.0))


class Work(Struct, frozen=True):
    """What one part needs done, and what of it cannot be."""

    ends: Ends
    jobs: tuple[Job, ...]
    skipped: dict[int, Diagnostic]  #: features left out by leave, and why
    repeats: tuple[int, ...]  #: duplicates of holes that are made
    sawn: tuple[int, ...]  #: contours that the cuts at the ends make
    refusals: tuple[Diagnostic, ...]
    remarks: tuple[Diagnostic, ...]


def work_on(part: Part, machine: Machine, saw: Saw, rack: Rack, skips: Collection[str]) -> Work:
    """What `part` needs done as it lies; refusals are in the result, and not raised."""
    try:
        ends, remarks = ends_of(part, saw.min_mitre)
    except PlanError as error:
        return Work(SQUARE, (), {}, (), (), error.diagnostics, ())
    turning = turning_saw(saw, machine)
    refusals = [said for end in ends if (said := refuse_cut(end, turning, part.source))]
    for said in judge_ends(part, ends, saw):
        if said.severity is Severity.ERROR:
            refusals.append(said)
        else:
            remarks = (*remarks, said)
    bench = _Bench(part, machine, rack, FinishedPart(part, ends, machine, rack.drill))
    holes = bench.sort_features(ends)
    kept, dropped = drop_duplicates(holes, rack.drill.duplicate_tolerance)
    bench.tell(judge_pairs(kept, rack.drill))
    if bench.slots:
        shapes: list[Shape] = [
            *bench.slots,
            *((f, hole) for _, f, hole in kept if hole.kind != "mark"),
        ]
        bench.tell(judge_slots(shapes, rack.drill))
    bench.refused |= refuse_too_near(kept, machine)
    bench.add_holes(kept)
    bench.drop_jobs()
    remarks = (*remarks, *(said for f, said in bench.told if f not in bench.refused))
    refused, skipped = bench.refused, {}
    if dropped:
        remarks = (*remarks, *_duplicate_remarks(part, dropped))
        # What repeats a hole that cannot be made cannot be made either.
        refused |= {f: refused[first] for f, (_, first, _) in dropped.items() if first in refused}
    if refused:
        skipped = {f: refused[f] for f in refused if _name(refused[f]) in skips}
        refusals += [refused[f] for f in sorted(refused) if f not in skipped]
    repeats = tuple(f for f in dropped if f not in refused) if dropped else ()
    jobs, sawn = tuple(bench.jobs), tuple(bench.sawn)
    return Work(ends, jobs, skipped, repeats, sawn, tuple(refusals), remarks)


def _name(said: Diagnostic) -> str:
    """What `--allow-skips` calls it."""
    return said.code.removeprefix("plan-")


def _duplicate_remarks(part: Part, dropped: dict[int, Placed]) -> Iterator[Diagnostic]:
    for f, (_, _, first) in dropped.items():
        hole = part.features[f]
        if isinstance(hole, Hole):
            yield rules.DUPLICATE.at(
                hole.source, found=f"{hole.diameter:g}", face=hole.face, x=f"{hole.x:g}",
                y=f"{hole.y:g}", first=first.source,
            )  # fmt: skip


class _Bench:
    """One part on one machine: takes its features, collects the jobs and what is refused."""

    def __init__(self, part: Part, machine: Machine, rack: Rack, finished: FinishedPart) -> None:
        self.part, self.machine, self.rack, self.finished = part, machine, rack, finished
        self.told: list[tuple[int, Diagnostic]] = []  #: remarks about features
        self.jobs: list[Job] = []
        self.refused: dict[int, Diagnostic] = {}
        self.slots: list[tuple[int, Slot]] = []  #: on the face that they are made from
        self.sawn: list[int] = []  #: contours that the cuts at the ends make
        self._reached = reach_of(part.profile, machine)
        self._behind: set[int] = set()  #: features that are made from the other side

    def sort_features(self, ends: Ends) -> Group:
        """The holes that a spindle reaches, along the part; of other features jobs or refusals."""
        holes: list[Placed] = []
        length, reached = self.part.length, self._reached
        for f, feature in enumerate(self.part.features):
            if not isinstance(feature, Hole):
                self._add_other(f, feature, ends)
                continue
            hole = feature
            reach = reached.get(hole.face)
            if reach is None:
                hole = self._from_behind(f, hole)
                reach = reached.get(hole.face)
            x, y, radius = hole.x, hole.y, hole.diameter / 2
            if (
                reach is not None
                and 0 <= x <= length
                and 0 <= y <= reach.width
                and reach.least <= y - radius
                and y + radius <= reach.greatest
            ):
                if self.finished.is_plain(hole) or self._is_in_part(f, hole):
                    holes.append((x, f, hole))
            else:
                self._refuse(f, refuse_place(hole, hole.face, self.part, reached))
        holes.sort()
        return tuple(holes)

    def tell(self, found: Iterable[tuple[int, Diagnostic]]) -> None:
        """Refuse the features that an error is said of, and keep what else is told of them."""
        for f, said in found:
            if said.severity is Severity.ERROR:
                self.refused.setdefault(f, said)
            else:
                self.told.append((f, said))

    def _is_in_part(self, f: int, hole: Hole | Slot) -> bool:
        """Whether the finished part holds a hole or slot; what is wrong with it is kept."""
        what = f"a slot of width {hole.diameter:g}" if isinstance(hole, Slot) else named(hole)
        circles = slot_ends(hole) if isinstance(hole, Slot) else ((hole.x, hole.y),)
        self.tell((f, said) for said in self.finished.judge(what, hole, circles))
        return f not in self.refused

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
        self._tell_of_face(f, hole, named(hole), face)
        return replace(hole, face=face)

    def _tell_of_face(self, f: int, shape: Hole | Slot, what: str, face: Face) -> None:
        """Say that a feature is made from another face than its own."""
        angle = self.part.profile.code == "L" and shape.face == "o"
        rule = finished_rules.ANGLE_FACE if angle else finished_rules.FROM_BEHIND
        said = rule.at(
            shape.source, what=what, x=f"{shape.x:g}", y=f"{shape.y:g}", face=shape.face,
            other=face,
        )  # fmt: skip
        self.told.append((f, said))

    def _add_other(self, f: int, feature: Feature, ends: Ends) -> None:
        if isinstance(feature, Slot):
            through = feature.depth is None and feature.kind == "through"
            face = face_at_work(feature.face, through, self.part.profile, self._reached)
            said = refuse_slot(feature, face, self.rack) or _refuse_slot_place(
                feature, face, self.part, self._reached
            )
            if not self._refuse(f, said) and self._is_in_part(f, replace(feature, face=face)):
                if face != feature.face:
                    self._tell_of_face(f, feature, f"a slot of width {feature.diameter:g}", face)
                self.slots.append((f, replace(feature, face=face)))
                self.jobs += slot_jobs(f, feature, face, self._reached[face].spindle, self.rack)
        else:
            said = refuse_other(feature, self.part, ends, self.rack, self._reached)
            if self._refuse(f, said):
                return
            if isinstance(feature, Contour) and feature.process == "cut":
                self.sawn.append(f)
            elif isinstance(feature, Contour):
                spindle = self._reached[feature.face].spindle
                job = scribe_job(f, feature, spindle, self.rack)
                self.jobs.append(job)
                beyond = self.finished.judge_line(feature, job.path)
                if beyond is not None:
                    self.told.append((f, beyond))

    def add_holes(self, holes: Group) -> None:
        """The jobs of all holes, each once and in order along the part."""
        sinks: list[Group] = []
        known = self.rack.toolings
        for group in merge_pairs(holes, partner_faces(self.machine), self.rack.drill):
            hole = group[0][2]
            if hole.kind == "countersink":
                sinks.append(group)
                continue
            if hole.kind != "through" or hole.depth is not None or self._behind:
                self._add_group(group)
                continue
            # Most holes are like one before, of this part or another, but for their place.
            key = hole.face, hole.diameter, group[1][2].diameter if len(group) == 2 else None
            tooling = known.get(key)
            if isinstance(tooling, Tooling):
                x, y, features = _place_of(group)
                self.jobs.append(Job(x, y, tooling, features, hole.source))
                continue
            count = len(self.jobs)
            self._add_group(group)
            if len(self.jobs) == count + 1 and not self.jobs[count].path:
                known.keep(key, self.jobs[count].tooling)
        if sinks:
            self._add_sinks(sinks, _pilots(holes, self.rack.drill))

    def _add_sinks(self, sinks: Sequence[Group], pilots: dict[int, Placed]) -> None:
        """The jobs of countersinks; of a pair one by one if they sink different holes.

        A sink stands on its hole, wherever a merge has put that one.
        """
        places = {f: (job.x, job.y) for job in self.jobs for f in job.features}
        for group in sinks:
            holes = [pilots.get(f) for _, f, _ in group]
            made = [p[2].diameter if p and p[1] not in self.refused else None for p in holes]
            at = [places[p[1]] if p and p[1] in places else None for p in holes]
            if len(set(made)) == 1:
                self._add_group(group, made[0], at[0])
            else:
                for placed, size, place in zip(group, made, at, strict=True):
                    self._add_group((placed,), size, place)

    def _add_group(
        self, group: Group, pilot: float | None = None, place: Point | None = None
    ) -> None:
        """The jobs of a hole or a pair; a pair for which there is no tool is made one by one.

        `pilot` is the diameter of the hole that a countersink sinks, and `place` where that stands.
        """
        _, f, hole = group[0]
        faces: tuple[Face, ...] = (hole.face,)
        diameters: tuple[float, ...] = (hole.diameter,)
        why: tuple[str, ...] = ()
        x, y, features = _place_of(group)
        if len(group) == 2:
            other = group[1][2]
            faces, why = (hole.face, other.face), ("merge-pair",)
            if other.diameter != hole.diameter:
                diameters = (hole.diameter, other.diameter)
        if place is not None:
            x, y = place
        steps = recipe(
            self.rack, hole.kind, diameters, hole.depth, hole.angle, faces,
            self.part.profile.thickness(hole.face), pilot,
        )  # fmt: skip
        if isinstance(steps, Refusal):
            if len(group) == 2:
                self._add_group((group[0],), pilot, place)
                self._add_group((group[1],), pilot, place)
            else:
                values = {"x": f"{x:g}", "y": f"{y:g}", **steps.values}
                self._refuse(f, steps.rule.at(hole.source, **values))
            return
        if f in self._behind:
            why = (*why, "from-behind")
        if hole.depth is not None:
            thickness = self.part.profile.thickness(hole.face)
            for _, f_of, each in group:
                point = judge_point(each, steps[0].tools[0], named(each), thickness)
                if point is not None:
                    self.told.append((f_of, point))
        number = self._number(faces)
        for step in steps:
            size = 0.0 if step.reason else diameters[0]
            reasons = (step.reason, *why) if step.reason else why
            path = self._ring(step, x, y) if step.ring else ()
            tooling = Tooling(number, step.tools, faces, step.depth, size, reasons)
            self.jobs.append(Job(x, y, tooling, features, hole.source, path))

    def drop_jobs(self) -> None:
        """Drop the jobs whose stroke does not fit or leads too far, and all beside them."""
        refused = dict(refuse_beyond(self.part, self.machine, self.jobs))
        if fixed_faces(self.machine):
            refused |= refuse_strokes(self.part, self.machine, self.rack.drill, self.jobs)
        if refused:
            self.refused |= refused
            self.jobs = [job for job in self.jobs if refused.keys().isdisjoint(job.features)]

    def _number(self, faces: tuple[Face, ...]) -> int:
        if len(faces) == 1:
            return self._reached[faces[0]].spindle
        return next(p.number for p in self.machine.pairs if set(p.faces) == set(faces))

    def _ring(self, step: Step, x: float, y: float) -> tuple[Point, ...]:
        mill, tolerance = step.tools[0].diameter, self.rack.drill.path_tolerance
        is_blind = step.depth is not None
        return pocket_path((x, y), (0.0, 0.0), 0.0, step.ring, mill, tolerance, is_blind)


def _place_of(group: Group) -> tuple[float, float, tuple[int, ...]]:
    """x and y of a hole, or of the middle of a pair; and the indices of its features."""
    x, f, hole = group[0]
    if len(group) == 1:
        return x, hole.y, (f,)
    other_x, other_f, other = group[1]
    return (x + other_x) / 2, (hole.y + other.y) / 2, (f, other_f)


def _pilots(holes: Group, drill: Drill) -> dict[int, Placed]:
    """For each countersink the hole that it sinks: of its face and place, the widest below it."""
    pilots = {}
    limit = drill.merge_tolerance
    for _, f, sink in holes:
        if sink.kind != "countersink":
            continue
        below = [
            (hole.diameter, other_f, placed)
            for placed in holes
            for _, other_f, hole in (placed,)
            if hole.kind in ("through", "blind", "thread", "left-thread")
            and hole.face == sink.face
            and abs(hole.x - sink.x) <= limit
            and abs(hole.y - sink.y) <= limit
            and hole.diameter < sink.diameter
        ]
        if below:
            pilots[f] = max(below)[2]
    return pilots


def _refuse_slot_place(
    slot: Slot, face: Face, part: Part, reached: Collection[Face]
) -> Diagnostic | None:
    places = ((slot.x, slot.y), *slot_ends(slot))
    said = (refuse_place(replace(slot, x=x, y=y), face, part, reached) for x, y in places)
    return next((d for d in said if d is not None), None)
