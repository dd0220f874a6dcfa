"""What a program makes against what its parts need: everything once, in its place, nothing else."""

from collections.abc import Collection, Iterator, Sequence
from math import isnan

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine, Saw
from beamcam.model.part import Part, Profile
from beamcam.verify import rules
from beamcam.verify.ends import ends_of
from beamcam.verify.made import Bore, Cut, Made
from beamcam.verify.matching import Matching, Wanted
from beamcam.verify.meaning import Meaning
from beamcam.verify.needs import Course, FeatureRef, Lack, Pocket, Stroke, needs_of
from beamcam.verify.placing import Placing
from beamcam.verify.plain import plainly_made
from beamcam.verify.rack import Rack
from beamcam.verify.stations import Choice
from beamcam.verify.strokes import Task, judge_strokes
from beamcam.verify.trails import judge_paths


def compare(
    made: Made,
    parts: Sequence[Part],
    machine: Machine,
    rack: Rack,
    meaning: Meaning,
    choices: dict[int, Choice],
    skipped: Collection[FeatureRef] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Every difference between a program and its parts, which lie on the bar in the order given.

    `skipped` names features that the program may leave out. Raises TypeError for a machine
    without saw and drill.
    """
    saw, drill = machine.saw, machine.drill
    if saw is None or drill is None:
        raise TypeError(f"{machine.name} has no saw and drill")
    said = [*_section(made, parts[0].profile, machine, name)]
    placing = Placing(made.cuts, machine, saw, name)
    by_part = {id(part): ends_of(part, saw) for part in parts}
    ends = [by_part[id(part)] for part in parts]
    placing.place(parts, ends)
    said += placing.said
    if meaning.saw_feeds:
        said += _saw_feeds(made.cuts, saw, name)
    task = Task(parts, machine, rack, meaning, choices, name, placing.starts)
    from_x = [drill.x + start for start in placing.starts]
    resolution = machine.format.resolution
    drilled = None if skipped else plainly_made(made.bores, parts, from_x, rack, resolution)
    wanted: list[Wanted] = []
    paths: list[Pocket | Course] = []
    for ref, need in needs_of(parts, ends, rack, (), drilled is None):
        if ref in skipped:
            if type(need) is Stroke:  # it may be missing, or be made all the same
                wanted.append(Wanted(need._replace(optional=True), from_x[need.part] + need.x))
        elif type(need) is Stroke:
            wanted.append(Wanted(need, from_x[need.part] + need.x))
        elif isinstance(need, Lack):
            said.append(_lack(need, parts))
        elif not isinstance(need, Stroke):
            paths.append(need)
    if drilled is None:
        matching = Matching(wanted, parts, resolution, rack, name)
        matches = sorted(matching.run(made.bores, said), key=lambda match: match.bore.line)
        said += judge_strokes(matches, task)
        drilled = [(match.need.part, match.bore) for match in matches]
    if made.trails or paths:
        said += judge_paths(made.trails, paths, task)
    if machine.layout is not None and machine.layout.order == "drill-saw":
        said += _after_its_cut(drilled, made, placing.last_cut, name)
    return tuple(said)


def _section(made: Made, profile: Profile, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """What the program says about the bar, against the parts' profile."""
    expected = {
        "height": profile.height,
        "width": profile.width,
        "section": float(machine.sections.get(profile.code, -1)),
    }
    for field, value in made.section:
        if not isnan(value) and abs(value - expected[field]) > 0.75 * machine.format.resolution:
            yield rules.SECTION.at(
                Source(name), what=field, found=f"{value:g}", expected=f"{expected[field]:g}"
            )


def _lack(need: Lack, parts: Sequence[Part]) -> Diagnostic:
    mark = parts[need.part].mark
    if need.place is None:
        return rules.NOT_MADE.at(need.feature.source, found=need.what, mark=mark)
    x, y = need.place
    face = getattr(need.feature, "face", "")
    return rules.OUTLINE.at(need.feature.source, face=face, mark=mark, x=f"{x:g}", y=f"{y:g}")


def _saw_feeds(cuts: Sequence[Cut], saw: Saw, name: str) -> Iterator[Diagnostic]:
    """Cuts that do not run at the saw's own feed."""
    for cut in cuts:
        if abs(cut.feed_mm_min - saw.feed_mm_min) > 0.1:
            yield rules.FEED.at(
                Source(name, cut.line),
                found=f"{cut.feed_mm_min:g}",
                what="the saw",
                expected=f"{saw.feed_mm_min:g}",
            )


def _after_its_cut(
    drilled: Sequence[tuple[int, Bore]], made: Made, last_cuts: Sequence[int | None], name: str
) -> Iterator[Diagnostic]:
    """Holes of a part, by its index, that has been parted before."""
    parted: dict[int, int] = {}  #: line of a cut -> its place in the order of work
    place: dict[int, int] = {}
    for index, op in enumerate(made.order):
        (parted if type(op) is Cut else place)[op.line] = index
    for part, bore in sorted(drilled, key=lambda one: one[1].line):
        line = last_cuts[part]
        if line is not None and place[bore.line] > parted[line]:
            yield rules.CUT_OFF.at(Source(name, bore.line), found=f"{bore.x:g}", cut=line)
