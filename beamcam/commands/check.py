"""`beamcam check`: a folder of golden programs, posted again and compared."""

import re
from pathlib import Path
from typing import Any

import click
from msgspec import Struct
from msgspec.structs import asdict

from beamcam import readers
from beamcam.commands import options
from beamcam.commands.common import REFUSED, Voice, say_json, say_lines
from beamcam.commands.programs import program_text
from beamcam.commands.settings import machine_for, settled
from beamcam.commands.tables import outputs, table_style
from beamcam.config.values import Config, over
from beamcam.diff.differ import Difference, diff_programs
from beamcam.diff.statements import diff_sheets
from beamcam.errors import BeamcamError, Diagnostic, errors_in
from beamcam.machine import Machine, shipped
from beamcam.pipeline import parts_of, post, read_file
from beamcam.planning.stock import from_store
from beamcam.report.run import as_message
from beamcam.verify.bars import run

#: Where others than the header of a machine file say the job's name: behind `%`, as the unit of a
#: program, in the head of a step table.
_JOB = re.compile(
    r"^%[ \t]+(.*\S)|^\(\* =+ UNIT unit_(\w+) =|^(?:#|/\*) beamcam/\w+/1 job (\S+) ", re.MULTILINE
)


class Checked(Struct, frozen=True):
    """What became of one golden program."""

    path: str
    result: str  #: "same", "bytes" (another text that means the same), "differs" or "refused"
    differences: tuple[Difference, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@click.command("check")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--samples",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    default=Path("samples"),
    show_default=True,
    help="Folder in which the parts are found, at any depth.",
)
@click.option(
    "--machine",
    shell_complete=options.machine_names,
    metavar="NAME",
    help="Of programs that lie in FOLDER itself; a subfolder names its own.",
)
@options.config
@options.bar
@options.skips
@options.strict
@options.as_json
@options.voiced
def command(
    folder: Path,
    samples: Path,
    machine: str | None,
    as_json: bool,
    voice: Voice,
    **asked: Any,
) -> None:
    """Post every golden program in FOLDER again and say what differs, by meaning and by bytes.

    FOLDER/MACHINE/a.gcode is made from the sample a on MACHINE, a+b.gcode from a and b on one
    bar. Exit status: 0 all are the same byte for byte, 1 one is not.

    \b
    beamcam check golden --samples parts
    beamcam check golden/beamline --machine beamline --samples parts
    """
    try:
        config = settled(asked, (str(folder),))
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    results = []
    for path, name in _programs(folder, machine or config.machine):
        results.append(_check(path, samples, over(config, {"machine": name})))
        voice.did(f"{path} on {name}: {results[-1].result}")
    if not results:
        raise click.UsageError(f"{folder}: found no program.")
    if as_json:
        records = [
            {
                "file": r.path,
                "result": r.result,
                "differences": [asdict(d) for d in r.differences],
                "messages": [as_message(d) for d in r.diagnostics if voice.wants(d.severity)],
            }
            for r in results
        ]
        say_json(records)
    else:
        for r in results:
            _show(r, voice)
        same = sum(r.result == "same" for r in results)
        if not voice.quiet:
            say_lines([f"{same} of {len(results)} programs are the same"])
    if any(r.result != "same" for r in results):
        raise SystemExit(REFUSED)


def _show(checked: Checked, voice: Voice) -> None:
    texts = {"bytes": "another text that means the same", "differs": "makes something else"}
    if checked.result != "same":
        say_lines([f"{checked.path}: {texts.get(checked.result, checked.result)}"])
    say_lines(f"  {difference.text}" for difference in checked.differences)
    voice.say(checked.diagnostics)


def _programs(folder: Path, machine: str | None) -> list[tuple[Path, str]]:
    """The golden programs and the machine of each, in order of their names."""
    found = [(p, machine or folder.name) for p in folder.iterdir() if _is_program(p, machine)]
    for below in folder.iterdir():
        if below.is_dir() and (below.name in shipped() or (below / "machine.toml").is_file()):
            own = below / "machine.toml"
            name = str(own) if own.is_file() else below.name
            found += [(p, name) for p in below.iterdir() if _is_program(p, name)]
    return sorted(found)


def _is_program(path: Path, machine: str | None) -> bool:
    return path.is_file() and not path.name.startswith(".") and path.suffix != ".toml" and (
        machine is not None or path.parent.name in shipped()
    )  # fmt: skip


def _check(path: Path, samples: Path, config: Config) -> Checked:
    try:
        old = program_text(str(path))
        found = (str(_sample(samples, name)) for name in path.stem.split("+"))
        parts, _ = parts_of(read_file(sample, config.strict) for sample in found)
        machine = machine_for(config, parts, str(path))
        style = table_style(machine, str(path), None)
        posted = from_store(
            lambda bar: post(
                parts, machine, _job(old, machine), bar, config.allow_skips, strict=config.strict,
                style=style,
            ),
            config.stock_lengths,
            max(part.length for part in parts),
        )  # fmt: skip
        new = dict(outputs(posted, machine, str(path)))[str(path)]
        new = new if isinstance(new, str) else b"".join(new).decode("utf-8", "replace")
    except BeamcamError as error:
        return Checked(str(path), "refused", (), error.diagnostics)
    if old == new:
        return Checked(str(path), "same")
    differences, said = _differences(old, new, machine, str(path))
    return Checked(str(path), "differs" if differences or said else "bytes", differences, said)


def _differences(
    old: str, new: str, machine: Machine, name: str
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    if machine.stock == "sheet":
        return diff_sheets(old, new, machine, name)
    first, second = run(old, machine, None, name), run(new, machine)
    found = diff_programs(first.made, second.made, machine.format.resolution)
    return found, errors_in(first.diagnostics)


def _job(text: str, machine: Machine) -> str:
    """The job's name as the golden program states it."""
    for line in machine.words.header:
        if "{job}" in line:
            stated = re.search(_stating(line), text, re.MULTILINE)
            if stated:
                return stated["job"]
    match = _JOB.search(text)
    return match[match.lastindex or 0] if match else "JOB"


def _stating(template: str) -> str:
    """The pattern of a line of a header that says the name of the job."""
    parts = re.split(r"\{(\w+)\}", template)  # every other part is the name of a value
    values = [r"(?P<job>.*\S)" if name == "job" else ".*" for name in parts[1::2]]
    texts = [re.escape(part) for part in parts[::2]]
    pattern = "".join(text + value for text, value in zip(texts, [*values, ""], strict=True))
    return f"^(?:N[0-9]+ )?{pattern}$"


def _sample(samples: Path, stem: str) -> Path:
    """The file of a sample, whatever its format; ends the process if there is none, or several."""
    suffixes = {s for f in readers.FORMATS for s in f.suffixes}
    found = sorted(
        p for p in samples.rglob(f"{stem}.*") if p.suffix.lower() in suffixes and p.stem == stem
        and "bad" not in p.relative_to(samples).parts
    )  # fmt: skip
    if len(found) != 1:
        names = ", ".join(map(str, found)) or "none"
        raise click.UsageError(f"sample {stem!r}: found {names}; expected one file in {samples}.")
    return found[0]
