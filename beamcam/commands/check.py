"""`beamcam check`: a folder of golden programs, posted again and compared."""

import re
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import click
from msgspec.structs import replace

from beamcam.commands import NO_SAMPLE, NOTHING, UNKNOWN, options
from beamcam.commands.batch import is_stock_list
from beamcam.commands.common import REFUSED, Console, cannot_write, outputs, say_lines, table_style
from beamcam.commands.golden import Checked, compared, named, sample_of, say_results
from beamcam.commands.parts import program_text, request_of
from beamcam.commands.recorded import DEFAULT_SAMPLES, Recorded, accept, record_folders
from beamcam.commands.settings import machines_for, settled
from beamcam.config.values import Config, over
from beamcam.errors import BeamcamError, Source
from beamcam.files import REFUSED_SUFFIX
from beamcam.machine import Machine, shipped
from beamcam.pipeline import begin, finished, parts_of, read_file
from beamcam.planning.manual_list import LIST_SUFFIX, manual_rows
from beamcam.readers import is_of_programs
from beamcam.reports.run import as_message

#: Where others than the header of a machine file say the job's name: behind `%`, as the unit of a
#: program, in the head of a step table.
_JOB = re.compile(
    r"^%[ \t]+(.*\S)|^\(\* =+ UNIT unit_(\w+) =|^(?:#|/\*) beamcam/\w+/1 job (\S+) ", re.MULTILINE
)

#: Files that may be beside programs.
_NO_PROGRAMS = (".toml", ".json", ".html", ".md", ".txt", REFUSED_SUFFIX)


@click.command("check")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--samples",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder in which the parts are found, at any depth; else where the batch found them, or "
    "samples.",
)
@click.option("--update", is_flag=True, help="Write the programs that have changed.")
@click.option(
    "--machine",
    shell_complete=options.machine_names,
    metavar="NAME",
    help="In place of that of the batch; of programs without a record, that of FOLDER itself.",
)
@click.option(
    "--stray",
    "patterns",
    multiple=True,
    metavar="PATTERN",
    help="Leave out programs that have no part here, as 'by-hand/*.gcode'; several times.",
)
@options.config
@options.bar
@options.skips
@options.strict
@options.as_json
@options.verbosity
def command(
    folder: Path, samples: Path | None, update: bool, patterns: tuple[str, ...], as_json: bool,
    console: Console, **values: Any,
) -> None:  # fmt: skip
    """Post every golden program in FOLDER again and say what differs, by meaning and by bytes.

    What `batch` wrote is posted again as its record says: the same inputs, machine, options, names
    and folders. Elsewhere FOLDER/MACHINE/a.gcode is made from the sample a on MACHINE, a+b.gcode
    from a and b on one bar. A change that several programs share is one line. Exit status: 0 all
    are the same byte for byte, or --update accepted what is not; 1 one is not, has no part, or
    there is none to compare.

    \b
    beamcam batch parts -o golden
    beamcam check golden
    beamcam check golden --update
    beamcam check golden --samples parts
    beamcam check golden/beamline --machine beamline --samples parts
    """
    results: list[Checked] = []
    try:
        config = settled(values, (str(folder),))
        known: set[Path] = set()
        for place in record_folders(folder):
            recorded = Recorded(place, samples, values, update)
            known |= {path.resolve() for path in recorded.paths}
            for one in recorded.check(folder):
                results.append(one)
                console.did(f"{one.path}: {one.result}")
        unknown: list[str] = []
        left_out = 0
        for path, name in _programs(folder, config.machine):
            if path.resolve() in known:
                continue
            if name is None and any(
                fnmatch(path.relative_to(folder).as_posix(), one) for one in patterns
            ):
                left_out += 1
                continue
            if name is None:
                unknown.append(str(path))
                continue
            named_so = over(config, {"machine": name})
            results.append(_check(path, samples or DEFAULT_SAMPLES, named_so))
            console.did(f"{path} on {name}: {results[-1].result}")
    except OSError as error:
        console.stop([cannot_write(str(error.filename or folder), error)])
    same = sum(r.result == "same" for r in results)
    more = f", {left_out} left out" if left_out else ""
    counts = f"{same} of {len(results) + len(unknown)} programs are the same{more}"
    if unknown or not results:
        counts, at = counts if results else "", Source(str(folder))
        fault = NOTHING.at(at)
        if unknown:
            fault = UNKNOWN.at(at, found=len(unknown), names=named(unknown))
        results.append(Checked(str(folder), "unknown", (), (as_message(fault),)))
    say_results(results, counts, console, as_json)
    try:
        left = accept(results) if update else results
    except OSError as error:
        console.stop([cannot_write(str(error.filename), error)])
    if console.for_people and len(left) < len(results):
        say_lines([f"{len(results) - len(left)} programs written"])
    if any(r.result != "same" for r in left):
        raise SystemExit(REFUSED)


def _programs(folder: Path, machine: str | None) -> list[tuple[Path, str | None]]:
    """The golden programs and the machine of each, None if it is not known; in order of names."""
    own = machine or (folder.name if folder.name in shipped() else None)
    programs = [(path, own) for path in folder.iterdir() if _is_program(path, own)]
    for below in (path for path in folder.rglob("*") if path.is_dir()):
        file = below / "machine.toml"
        name = str(file) if file.is_file() else below.name if below.name in shipped() else None
        if name is not None and below.parent != folder:
            name = None  # a machine's folder lies in the folder itself
        programs += [(path, name) for path in below.iterdir() if _is_program(path, name)]
    return sorted(programs, key=lambda one: one[0])


def _is_program(path: Path, machine: str | None) -> bool:
    """Whether a file is one, in the folder of a machine, or is called as programs are."""
    if not path.is_file() or path.name.startswith(".") or path.name.lower().endswith(LIST_SUFFIX):
        return False
    if is_stock_list(str(path)):
        return False
    return is_of_programs(path.name) or (machine is not None and path.suffix not in _NO_PROGRAMS)


def _check(path: Path, samples: Path, config: Config) -> Checked:
    try:
        old = program_text(str(path))
        sources = (str(sample_of(samples, name, str(path))) for name in path.stem.split("+"))
        parts, _ = parts_of(read_file(sample, config.strict) for sample in sources)
        machine = machines_for(config, parts, str(path))[0]
        style = table_style(machine, str(path), None)
        request = request_of(parts, config, machine, None, {})
        named_so = replace(request, name=_job(old, machine), style=style)
        (begun,) = begin(named_so, together=True)
        posted = finished(begun)
        new = dict(outputs(posted, machine, str(path)))[str(path)]
        data = new.encode() if isinstance(new, str) else b"".join(new)
    except BeamcamError as error:
        missing = any(one.code == NO_SAMPLE.code for one in error.diagnostics)
        messages = tuple(map(as_message, error.diagnostics))
        return Checked(str(path), "missing" if missing else "refused", (), messages)
    return compared(str(path), path.read_bytes(), data, machine, manual_rows(posted.plan))


def _job(text: str, machine: Machine) -> str:
    """The job's name as the golden program states it."""
    for line in machine.words.header:
        if "{job}" in line:
            parts = re.split(r"\{(\w+)\}", line)  # every other part is the name of a value
            parts[::2] = map(re.escape, parts[::2])
            parts[1::2] = (r"(?P<job>.*\S)" if n == "job" else ".*" for n in parts[1::2])
            match = re.search(f"^(?:N[0-9]+ )?{''.join(parts)}$", text, re.MULTILINE)
            if match:
                return match["job"]
    match = _JOB.search(text)
    return match[match.lastindex or 0] if match else "JOB"
