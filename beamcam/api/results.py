"""What is seen of a program from Python: its axes over time, its parts, pictures and sheets, and
how two of them differ."""

from collections.abc import Iterable
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Literal, get_args

from msgspec import Struct
from msgspec.structs import replace

from beamcam.api.inputs import FileInput, check_choice, check_text, checked_parts
from beamcam.api.jobs import post, program_bytes
from beamcam.arguments import ASK_TYPE, AnyMachine, AskError, ask_type, machine_of
from beamcam.checks.job import head_of
from beamcam.comparison.pairing import Difference
from beamcam.comparison.statements import ProgramText, diff_texts
from beamcam.controllers.dialect import ARC, SYNTAX, WORD
from beamcam.errors import Diagnostic, Severity, Source, VerifyError, errors_in
from beamcam.machine.machine import DEFAULT_MACHINE
from beamcam.model.part import Part, Profile
from beamcam.model.plan import Plan
from beamcam.model.request import Request
from beamcam.pipeline import Posted, read_back

if TYPE_CHECKING:
    from beamcam.pictures import ReadProgram
    from beamcam.recovery import Recovered
    from beamcam.simulation.program import Simulated

# --- comparison: two programs of a machine compared by what they mean -----------------------------

#: Faults that make a program's meaning unknown.
NOT_UNDERSTOOD = {r.code for r in (SYNTAX, WORD, ARC)}


class ComparisonResult(Struct, frozen=True):
    """What the second of two programs or parts makes otherwise, and what is wrong with them."""

    differences: tuple[Difference, ...]
    diagnostics: tuple[Diagnostic, ...]


def compared(a: ProgramText, b: ProgramText) -> ComparisonResult:
    """What the second of two programs makes otherwise.

    Raises VerifyError where their blocks are not understood; AskError for a program of bars and one
    of sheets.
    """
    if a.machine.stock != b.machine.stock:
        one, other = (f"a program for {p.machine.name}, a {p.machine.stock}" for p in (b, a))
        raise AskError(ASK_TYPE.at(Source(b.name), name="b", found=one, expected=f"one as {other}"))
    different, diagnostics = diff_texts(a, b)
    is_sheet = a.machine.stock == "sheet"
    if (is_sheet and diagnostics) or any(one.code in NOT_UNDERSTOOD for one in diagnostics):
        raise VerifyError(diagnostics)
    if is_sheet:
        diagnostics = tuple(
            fault
            for one in (a, b)
            for fault in read_back(one.text, Request((), one.machine, name=one.name))
            if fault.severity is not Severity.NOTE
        )
    heads = [head_of(one.text) for one in (a, b)]
    old, new = (0 if head is None else head.manual_work for head in heads)
    if old != new:
        text = f"marks left for manual work: {old} in A, {new} in B"
        different = (*different, Difference("feature", "changed", text))
    return ComparisonResult(tuple(different), diagnostics)


Picture = Literal["svg", "png", "pdf"]
Unit = Literal["mm", "inch"]
Paper = Literal["a4", "a3"]


def simulate(
    program: FileInput, machine: AnyMachine = DEFAULT_MACHINE, *,
    parts: Part | Iterable[Part] = (), name: str = "program",
) -> "Simulated":  # fmt: skip
    """The axes of the machine over time while it runs a program: `trace`, and `diagnostics`.

    `parts` say which section or sheet it is, where the program does not; `name` is the program's,
    its suffix the form of a step table. Axes beyond their limits and bodies that strike are
    warnings. Raises VerifyError for a program that cannot be understood, and MachineError.
    """
    from beamcam.simulation.limits import run_warnings
    from beamcam.simulation.program import simulate_program

    check_text("name", name)
    loaded = machine_of(machine)
    data, style = program_bytes(program), PurePath(name).suffix.lower()
    done = simulate_program(data, loaded, name, style, checked_parts(parts))
    if errors_in(done.diagnostics):
        raise VerifyError(done.diagnostics)
    diagnostics = run_warnings(done.trace, loaded, done.section, name)
    return replace(done, diagnostics=(*done.diagnostics, *diagnostics))


def diff(
    a: FileInput | Part | Iterable[Part],
    b: FileInput | Part | Iterable[Part],
    machine: AnyMachine | None = None,
) -> ComparisonResult:
    """What `b` makes otherwise than `a`: two programs, or two parts or lists of them.

    Each program is read by the machine that its own head names, unless one is given for both.
    Raises VerifyError where the blocks of a program are not understood.
    """
    if _is_parts(a) and _is_parts(b):
        from beamcam.comparison.parts import diff_parts

        return ComparisonResult(diff_parts(checked_parts(a), checked_parts(b)), ())  # type: ignore[arg-type]
    if _is_parts(a) or _is_parts(b):
        raise AskError(ask_type("b", type(b).__name__, "two programs, or two parts"))
    texts = []
    for name, text in (("A", _text(a)), ("B", _text(b))):
        head = head_of(text)
        used = machine or (DEFAULT_MACHINE if head is None else head.machine)
        texts.append(ProgramText(name, text, machine_of(used)))
    return compared(*texts)


def recover(
    program: FileInput, machine: AnyMachine = DEFAULT_MACHINE, *,
    profile: str | Part | None = None, name: str = "program",
) -> "Recovered":  # fmt: skip
    """The parts that a program makes, and remarks; none where an error is said.

    `profile` is the section of the bar: a name such as "IPE200", or a part that has it. The program
    was read back against what was found.
    """
    from beamcam.machine.tables import TABLE_CONTROLLERS
    from beamcam.model.section import measures_of
    from beamcam.recovery import KnownStock
    from beamcam.recovery import recover as recover_parts

    check_text("name", name)
    stock = KnownStock()
    if isinstance(profile, Part):
        stock = KnownStock(profile.profile, profile.grade)
    elif profile is not None:
        check_text("profile", profile, Part)
        known = measures_of(profile)
        if known is None:
            raise AskError(ask_type("profile", profile, "a section such as IPE200, or a Part"))
        code, sizes = known
        stock = KnownStock(Profile(code, profile.upper(), *sizes))
    used = machine_of(machine)
    if used.controller in TABLE_CONTROLLERS:
        raise AskError(ask_type("machine", used.name, "one for bars, or a table that runs G-code"))
    return recover_parts(_text(program), used, name, stock)


def plot(
    shown: FileInput | Part, machine: AnyMachine | None = None, *, to: Picture = "svg",
    unit: Unit = "mm", paper: Paper = "a4", name: str = "program", bar: float | None = None,
    parts: Part | Iterable[Part] = (),
) -> str | bytes:  # fmt: skip
    """A picture of a part with its faces unfolded, or of what a program makes on its machine.

    It is the text of an SVG, or the bytes of a PNG, or of a PDF on a paper. Raises PictureError
    without the library of the format, VerifyError for a program that cannot be understood.
    """
    check_choice("to", to, get_args(Picture))
    check_choice("unit", unit, get_args(Unit))
    check_choice("paper", paper, get_args(Paper))
    if isinstance(shown, Part):
        from beamcam.pictures.part import part_scene

        torch = machine_of(machine).torch if machine is not None else None
        scene = part_scene(checked_parts(shown)[0], unit, torch.colours if torch else None)
    else:
        from beamcam.pictures.program import program_scene

        scene = program_scene(_read_program(shown, machine, name, bar, parts), unit)
    from beamcam.pictures.formats import picture

    return picture([scene], f".{to}", paper)


def report(
    parts: Part | Iterable[Part] = (), machine: AnyMachine = DEFAULT_MACHINE, *,
    program: FileInput | Posted | None = None, to: Literal["html", "pdf"] = "html",
    unit: Unit = "mm", paper: Paper = "a4", name: str = "program", bar: float | None = None,
    skips: Iterable[str] = (),
) -> str | bytes:  # fmt: skip
    """The setup sheet of the program that makes `parts`: posted for it, or the one that is given.

    It is an HTML page, or the bytes of a PDF on a paper. Raises what `post` raises, and
    PictureError.
    """
    from beamcam.setup_sheet.content import SheetSources, content_of

    check_choice("to", to, ("html", "pdf"))
    check_choice("unit", unit, get_args(Unit))
    check_choice("paper", paper, get_args(Paper))
    loaded, all_parts, left_out = machine_of(machine), checked_parts(parts), tuple(skips)
    if program is None:
        program = post(all_parts, loaded, bar=bar, skips=left_out)
    if isinstance(program, Posted):
        plan, data = program.plan, b"".join(program.pieces())
        length = plan.bar.length if isinstance(plan, Plan) else None
        read = _read_program(data, loaded, f"{name}{loaded.suffix}", length, all_parts)
        source = SheetSources(read, plan, program.remarks)
    else:
        read = _read_program(program, loaded, name, bar, all_parts)
        request = Request(all_parts, loaded, left_out, name, style=read.style)
        source = SheetSources(read, None, (), read_back(read.data, request, bar))
    content = content_of(source, unit)
    if to == "pdf":
        from beamcam.setup_sheet.paper import setup_pdf

        return setup_pdf(content, paper)
    from beamcam.setup_sheet.page import setup_page

    return setup_page(content)


def _is_parts(value: object) -> bool:
    return isinstance(value, Part | tuple | list)


def _text(program: object) -> str:
    return program_bytes(program).decode("utf-8", "replace")


def _read_program(
    program: Any, machine: AnyMachine | None, name: str, bar: float | None,
    parts: Part | Iterable[Part],
) -> "ReadProgram":  # fmt: skip
    from beamcam.pictures import ReadProgram

    check_text("name", name)
    loaded = machine_of(DEFAULT_MACHINE if machine is None else machine)
    style = PurePath(name).suffix.lower()
    return ReadProgram(program_bytes(program), loaded, name, style, checked_parts(parts), bar)
