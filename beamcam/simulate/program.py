"""Any program on the model of its machine: interpreted as the read-back does, then timed.

text -> events (controllers) -> trace; what is wrong with the program by itself is reported
"""

from collections.abc import Mapping, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, VerifyError, errors_in
from beamcam.machine.coper_faults import refuse_coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.simulate.trace import Trace


class Simulated(Struct, frozen=True):
    """A program that ran on the model of its machine."""

    trace: Trace
    diagnostics: tuple[Diagnostic, ...]  #: what is wrong with it by itself
    section: Mapping[str, float] = {}  #: of the bar, as far as the program says it
    kerf_offset: float = 0.0  #: mm that the controller keeps off the path (G41, G42), at most


def simulate_program(
    data: str | bytes,
    machine: Machine,
    name: str = "program",
    style: str = "",
    parts: Sequence[Part] = (),
) -> Simulated:
    """The axes of a machine over time while it runs a program.

    `style` is the suffix of a step table; the machine's own where it is none of its forms.
    `parts` say what sheet is cut and what section is sawn, where the program does not.
    Raises VerifyError for a program that cannot be understood, MachineError for a cell without
    `[[axes]]` and for a coper.
    """
    refuse_coper(machine, "the model of motion")
    if machine.stepper is not None:
        return _steps(data, machine, name, style)
    text = data if isinstance(data, str) else data.decode("utf-8", "replace")
    if machine.stock == "beam":
        return _bar(text, machine, name, parts)
    if machine.triggers is not None:
        return _triggers(text, machine, name)
    return _sheet(text, machine, name, parts)


def _bar(text: str, machine: Machine, name: str, parts: Sequence[Part]) -> Simulated:
    from beamcam.simulate.bars import bar_trace
    from beamcam.simulate.course import stretches
    from beamcam.verify.bars import run

    done = run(text, machine, parts[0].profile if parts else None, name)
    section = dict(done.made.section)
    seen = section or ({"width": parts[0].profile.width} if parts else {})
    course = stretches(done.events, done.dialect, seen, machine)
    return Simulated(bar_trace(course, machine), done.diagnostics, section)


def _sheet(text: str, machine: Machine, name: str, parts: Sequence[Part]) -> Simulated:
    from beamcam.controllers import table_events, table_run
    from beamcam.simulate.sheets import sheet_trace
    from beamcam.verify.sheets.need import rows_of
    from beamcam.verify.sheets.strokes import strokes_of

    torch = machine.needed(machine.torch, "torch")
    done, said = table_run(text, machine, name)
    if errors_in(said):
        raise VerifyError(said)
    rows = rows_of(parts[0], torch) if parts else torch.rows
    strokes, _ = strokes_of(
        done, machine, torch, rows, lambda blocks: table_events(blocks, machine)[0], name
    )
    starts = {stroke.line: (stroke.process, stroke.waits_s) for stroke in strokes.each}
    stops = {done.others[stroke.off][1].line for stroke in strokes.each if stroke.off >= 0}
    offset = max((stroke.radius for stroke in strokes.each if stroke.side), default=0.0)
    return Simulated(
        sheet_trace(done.events(), starts, stops, machine), tuple(said), kerf_offset=offset
    )


def _triggers(text: str, machine: Machine, name: str) -> Simulated:
    from beamcam.controllers.simotion import read_program
    from beamcam.simulate.triggers import trigger_trace

    job, said = read_program(text, machine, name)
    if job is None:
        raise VerifyError(said)
    return Simulated(trigger_trace(job, machine), tuple(said))


def _steps(data: str | bytes, machine: Machine, name: str, style: str) -> Simulated:
    from beamcam.controllers.step_table.header import header_rows
    from beamcam.controllers.step_table.rows import Stream, TableFault, binary_rows, text_rows
    from beamcam.simulate.steps import step_trace, velocity_trace
    from beamcam.verify.steps import FORMS, VELOCITIES
    from beamcam.verify.steps.velocities import stretches

    stepper = machine.needed(machine.stepper, "stepping motors")
    form = style if style in FORMS else machine.suffix
    stream = Stream((data.encode() if isinstance(data, str) else data,), name)
    try:
        if form == VELOCITIES:
            return Simulated(velocity_trace(stretches(stream, stepper.step), machine), ())
        rows = {".steps": text_rows, ".bin": binary_rows, ".h": header_rows}[form]
        return Simulated(step_trace(rows(stream, stepper), machine), ())
    except TableFault as fault:
        raise VerifyError(fault.diagnostic) from fault
