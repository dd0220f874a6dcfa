"""`beamcam check`: a folder of golden programs, posted again and compared."""

import json
import re
from pathlib import Path

import click
from msgspec import Struct
from msgspec.structs import asdict

from beamcam import readers
from beamcam.commands.common import REFUSED, as_record, say
from beamcam.commands.tables import outputs, table_style
from beamcam.errors import BeamcamError, Diagnostic, errors_in
from beamcam.machine import Machine, load, shipped
from beamcam.pipeline import parts_of, post, read_file
from beamcam.planning import SKIP_NAMES
from beamcam.verify import run
from beamcam.verify.differ import Difference, diff_programs
from beamcam.verify.statements import diff_sheets


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
@click.option("--machine", help="Of programs that lie in FOLDER itself; a subfolder names its own.")
@click.option("--bar", type=click.FloatRange(min=0, min_open=True), help="Length of the bar, mm.")
@click.option(
    "--allow-skips", "skips", multiple=True, type=click.Choice(SKIP_NAMES), help="As for post."
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as a JSON list.")
def command(
    folder: Path,
    samples: Path,
    machine: str | None,
    bar: float | None,
    skips: tuple[str, ...],
    as_json: bool,
) -> None:
    """Post every golden program in FOLDER again and say what differs, by meaning and by bytes.

    FOLDER/MACHINE/a.gcode is made from the sample a on MACHINE, a+b.gcode from a and b on one
    bar. Exit status: 0 all are the same byte for byte, 1 one is not.

    \b
    beamcam check golden --samples parts
    beamcam check golden/beamline --machine beamline --samples parts
    """
    results = [_check(path, samples, name, bar, skips) for path, name in _programs(folder, machine)]
    if not results:
        raise click.UsageError(f"{folder}: found no program.")
    if as_json:
        records = [
            {
                "file": r.path,
                "result": r.result,
                "differences": [asdict(d) for d in r.differences],
                "messages": [as_record(d) for d in r.diagnostics],
            }
            for r in results
        ]
        click.echo(json.dumps(records, ensure_ascii=False, indent=1))
    else:
        for r in results:
            _show(r)
        same = sum(r.result == "same" for r in results)
        click.echo(f"{same} of {len(results)} programs are the same")
    if any(r.result != "same" for r in results):
        raise SystemExit(REFUSED)


def _show(checked: Checked) -> None:
    texts = {"bytes": "another text that means the same", "differs": "makes something else"}
    if checked.result != "same":
        click.echo(f"{checked.path}: {texts.get(checked.result, checked.result)}")
    for difference in checked.differences:
        click.echo(f"  {difference.text}")
    say(checked.diagnostics)


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


def _check(
    path: Path, samples: Path, machine: str, bar: float | None, skips: tuple[str, ...]
) -> Checked:
    try:
        loaded = load(machine)
        old = path.read_bytes().decode("utf-8", "replace")
        parts, _ = parts_of(read_file(str(_sample(samples, n))) for n in path.stem.split("+"))
        style = table_style(loaded, str(path), None)
        posted = post(parts, loaded, _job(old), bar, skips, style=style)
        new = dict(outputs(posted, loaded, str(path)))[str(path)]
        new = new if isinstance(new, str) else b"".join(new).decode("utf-8", "replace")
    except BeamcamError as error:
        return Checked(str(path), "refused", (), error.diagnostics)
    if old == new:
        return Checked(str(path), "same")
    differences, said = _differences(old, new, loaded, str(path))
    return Checked(str(path), "differs" if differences or said else "bytes", differences, said)


def _differences(
    old: str, new: str, machine: Machine, name: str
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    if machine.stock == "sheet":
        return diff_sheets(old, new, machine, name)
    first, second = run(old, machine, None, name), run(new, machine)
    found = diff_programs(first.made, second.made, machine.format.resolution)
    return found, errors_in(first.diagnostics)


def _job(text: str) -> str:
    """The job's name as the golden program states it."""
    match = re.search(r"^%[ \t]+(.*\S)", text, re.MULTILINE)
    return match[1] if match else "JOB"


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
