"""Two folders of programs or parts, compared file by file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from beamcam.batch.record import RECORD_NAME
from beamcam.commands.common import REFUSED, Voice, say_json, say_lines
from beamcam.commands.comparison import differences_of, is_part
from beamcam.commands.golden import Checked, Result, records, told
from beamcam.commands.recorded import Recorded
from beamcam.commands.settings import machine_for_program, settled
from beamcam.config.values import COMMAND_LINE, Config
from beamcam.errors import BeamcamError, Severity, errors_in
from beamcam.machine import Machine
from beamcam.machine.names import is_of_programs
from beamcam.report.run import as_message, message_line


def diff_folders(a: Path, b: Path, as_json: bool, voice: Voice, asked: Mapping[str, Any]) -> None:
    """Print what the files of `b` make otherwise than those of `a`, and end with the status."""
    try:
        config = settled(asked, (str(a), str(b)))
        recorded = _recorded(a) | _recorded(b)
        first, second = _files(a, recorded), _files(b, recorded)
        results = []
        for name in sorted(first.keys() & second.keys()):
            results.append(_compared(name, first[name], second[name], recorded, config))
            voice.did(f"{name}: {results[-1].result}")
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    alone = [(str(a / name), "only in A") for name in sorted(first.keys() - second.keys())]
    alone += [(str(b / name), "only in B") for name in sorted(second.keys() - first.keys())]
    wanted = [severity.value for severity in Severity if voice.wants(severity)]
    if as_json:
        rows = records(results, wanted)
        rows += [
            {"file": name, "result": where, "differences": [], "messages": []}
            for name, where in alone
        ]
        say_json(rows)
    else:
        say_lines(told([one for one in results if one.result != "bytes"]))
        say_lines(f"{name}: {where}" for name, where in alone)
        said = (m for one in results for m in one.messages if m["severity"] in wanted)
        say_lines(map(message_line, said), err=True)
        if not voice.quiet:
            same = sum(one.result in ("same", "bytes") for one in results)
            say_lines([f"{same} of {len(results) + len(alone)} files mean the same"])
    if alone or any(one.result not in ("same", "bytes") for one in results):
        raise SystemExit(REFUSED)


def _recorded(folder: Path) -> dict[str, Machine]:
    """The machine of each program that a record in the folder knows."""
    return Recorded(folder, None, {}, False).machines() if (folder / RECORD_NAME).is_file() else {}


def _files(folder: Path, recorded: Mapping[str, Machine]) -> dict[str, Path]:
    """The programs and parts below a folder by their names there."""
    found = {}
    for path in folder.rglob("*"):
        name = path.relative_to(folder).as_posix()
        if path.name.startswith(".") or not path.is_file():
            continue
        if name in recorded or is_of_programs(name) or is_part(name, path.read_bytes()):
            found[name] = path
    return found


def _machine(config: Config, name: str, data: bytes, recorded: Mapping[str, Machine]) -> Machine:
    """The machine that a program is for: what is asked for, else what the record says."""
    if name in recorded and config.sources.get("machine") != COMMAND_LINE:
        return recorded[name]
    return machine_for_program(config, name, data)


def _compared(
    name: str, first: Path, second: Path, recorded: Mapping[str, Machine], config: Config
) -> Checked:
    shown = str(second)
    old, new = first.read_bytes(), second.read_bytes()
    if old == new:
        return Checked(shown, "same")
    try:
        machines = [_machine(config, name, data, recorded) for data in (old, new)]
        found, said = differences_of([(str(first), old), (shown, new)], machines, config.strict)
    except BeamcamError as error:
        return Checked(shown, "refused", (), tuple(map(as_message, error.diagnostics)))
    refused = errors_in(said)
    result: Result = "differs" if found else "refused" if refused else "bytes"
    return Checked(shown, result, found, tuple(map(as_message, said)))
