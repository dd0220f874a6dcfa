"""Machine files proved by a small part: what is written for it by their words is read back.

`controllers.machine_words` tries each template by itself; here all of them stand in a program, in
the order in which programs have them. What the read-back refuses of it, it would refuse of any
part: it is a fault of the file. A file with which nothing can be planned has no such program, and
is refused for each part by its planner.
"""

import re
from collections.abc import Iterator

from beamcam.caches import PerObject
from beamcam.checks.job import head_of
from beamcam.controllers.machine_words import WordFault, fault_in
from beamcam.emitters.gcode import head_lines
from beamcam.errors import Diagnostic, PlanError, Source, errors_in
from beamcam.geometry.curves import Arc, Bezier, Curve, Line
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndCuts, Feature, Hole, Part, Process, Profile
from beamcam.model.plan import SKIP_NAMES, left_out_kinds, manual_work_sources
from beamcam.model.request import Job, Request
from beamcam.posts import beginning, carries_head, post_of

_AT = Source("the plate or bar on trial")
_NAME = "JOB"
_LENGTH = 1000.0  #: mm of the bar's part, if the machine makes so short ones
#: A section of each kind that bars have, by their DSTV codes.
_SECTIONS = (
    Profile("I", "IPE200", 200.0, 100.0, 8.5, 5.6, 12.0),
    Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    Profile("L", "L100x10", 100.0, 100.0, 10.0, 10.0, 12.0),
    Profile("M", "RHS100x5", 100.0, 100.0, 5.0, 5.0, 5.0),
    Profile("RO", "CHS100x5", 100.0, 100.0, 0.0, 5.0),
    Profile("RU", "RD50", 50.0, 50.0, 0.0, 0.0),
    Profile("B", "FL100x10", 100.0, 0.0, 0.0, 10.0),
)


def proof_faults(machine: Machine) -> tuple[WordFault, ...]:
    """What the read-back refuses of the program of a small part, by the words that wrote it."""
    for part in _parts(machine):
        job = Job(Request((part,), machine, SKIP_NAMES, _NAME), (0,))
        post = post_of(machine)
        try:
            plan = post.plan(job)
            manual_work = sum(1 for _ in manual_work_sources(plan))
            head = tuple(head_lines(job, plan, left_out_kinds(plan), manual_work))
            written = post.emit(post.with_head(post.motion(plan, machine, _NAME), head), job)
        except PlanError:
            continue  # the next one asks for less
        if carries_head(job) and head_of(beginning(written)) is None:
            text = machine.words.comment
            expected = "a comment with {text}, for the head"
            return (fault_in("words.comment", text, repr(text), expected),)
        diagnostics = errors_in(post.verify(written, job))
        lines = written.splitlines() if isinstance(written, str) else []
        return tuple(_fault(one, lines, machine) for one in diagnostics)
    return ()


known_proof_faults = PerObject("machine.proof", proof_faults)


def _fault(diagnostic: Diagnostic, lines: list[str], machine: Machine) -> WordFault:
    """The key of the words and the line of theirs by which the block was written; its fault."""
    line, block = diagnostic.source.line, ""
    if diagnostic.source.file == _NAME and line and line <= len(lines):
        block = lines[line - 1]
    for name in machine.words.__struct_fields__:
        template = getattr(machine.words, name)
        for text in (template,) if isinstance(template, str) else template:
            pattern = re.sub(r"\\\{.*?\\\}", ".*", re.escape(text))
            if text.strip() and block and re.fullmatch(rf"(N\d+ )?{pattern}.*", block):
                return f"words.{name}", text, diagnostic.message
    return "words", "", diagnostic.message


# --- parts ----------------------------------------------------------------------------------------


def _parts(machine: Machine) -> Iterator[Part]:
    """Parts that prove a machine, the one that asks for most first."""
    if machine.torch is not None:
        yield from _sheets(machine)
        return
    if (coper := machine.coper) is not None:
        for profile in _SECTIONS:
            if profile.code in coper.profiles:
                thick = profile.web_thickness or 0.0
                size = max(20.0, coper.min_hole, coper.min_hole_share * thick)
                hole = Hole("v", 300.0, 0.45 * profile.height, size, _AT)
                yield Part("P1", profile, _LENGTH, _AT, features=(hole,))
                yield Part("P1", profile, _LENGTH, _AT)
        return
    profiles = machine.layout.profiles if machine.layout else ()
    sizes = [size for tools in machine.tools if tools.kind == "drill" for size in tools.sizes]

    def near(size: float) -> float:
        return min(sizes, key=lambda one: abs(one - size))

    for profile in _SECTIONS:
        if profile.code in profiles:
            features: list[Hole] = []  # two on each face that a spindle reaches, by two tools
            for spindle in machine.spindles if sizes else ():
                width = profile.face_width(spindle.face)
                y = width / 2 if spindle.face == "v" or profile.code != "I" else width / 5
                features += (
                    Hole(spindle.face, 300.0, y, near(14.0), _AT),
                    Hole(spindle.face, 600.0, y, near(18.0), _AT),
                )
            holes = tuple(features)
            length = max(_LENGTH, 1.1 * machine.layout.min_part if machine.layout else 0.0)
            yield Part("P1", profile, length, _AT, features=holes, cuts=EndCuts(web_end=20.0))
            yield Part("P1", profile, length, _AT, features=holes)
            yield Part("P1", profile, length, _AT)


def _sheets(machine: Machine) -> Iterator[Part]:
    assert machine.torch is not None
    cut = next(row for row in machine.torch.rows if row.process == "cut")
    profile = Profile("B", "PL", 80.0, 0.0, 0.0, machine.torch.thickness or cut.up_to)
    outer: tuple[Curve, ...] = (
        Line((0.0, 0.0), (120.0, 0.0)), Line((120.0, 0.0), (120.0, 60.0)),
        Arc((100.0, 60.0), 20.0, 0.0, 90.0), Line((100.0, 80.0), (0.0, 80.0)),
        Line((0.0, 80.0), (0.0, 0.0)),
    )  # fmt: skip
    free: tuple[Curve, ...] = (
        Bezier(((60.0, 20.0), (60.0, 50.0), (100.0, 50.0), (100.0, 20.0))),
        Line((100.0, 20.0), (60.0, 20.0)),
    )
    round_hole: tuple[Curve, ...] = (Arc((30.0, 40.0), 15.0, 0.0, 360.0),)
    cuts = [
        _contour(outer, "outer"), _contour(round_hole, "inner"), _contour(free, "inner"),
    ]  # fmt: skip
    rest = dict.fromkeys(row.process for row in machine.torch.rows if row.process != "cut")
    others: list[Feature] = [
        _contour((Line((20.0, 4.0 + 7 * k), (50.0, 4.0 + 7 * k)),), "open", process)
        for k, process in enumerate(rest)
        if process != "spot"
    ]
    if machine.torch.drilled == "spot":
        others.append(Hole("v", 100.0, 10.0, 0.0, _AT, kind="mark"))
    for features in ((*cuts, *others), cuts, cuts[:2]):
        yield Part("P1", profile, 120.0, _AT, features=tuple(features))


def _contour(curves: tuple[Curve, ...], kind: str, process: Process = "cut") -> Contour:
    return Contour("v", kind, curves, _AT, process, kind != "open")  # type: ignore[arg-type]
