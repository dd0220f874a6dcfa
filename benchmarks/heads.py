"""Programs whose heads say otherwise than what was asked for, all to be refused by `post`.

A head is removed, allows kinds that were not named, allows none of those that were named, was made
by another form or for another machine file, says another stock, or a part elsewhere, larger or not
at all; on every machine whose programs have a head.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

from msgspec.structs import replace

from beamcam import pipeline
from beamcam.checks.job import VERSION
from beamcam.errors import VerifyError
from beamcam.machine import Machine, load
from beamcam.model.request import Job
from beamcam.pipeline import parts_of, post, read_file
from beamcam.posts import post_of

ROOT = Path(__file__).resolve().parent.parent
SKIPS = ("cope", "slot")
Change = Callable[[str, Machine], str]

#: A sample that each machine makes, and what it needs to be told.
SAMPLES = {
    "beamline": "dstv/channel.nc1", "beamline-annex": "dstv/channel.nc1",
    "beamline-pusher": "dstv/channel.nc1", "plate-codesys": "dstv/gusset.nc1",
    "plate-linuxcnc": "dstv/gusset.nc1", "laser-grbl": "json/shield-small.json",
    "table-simotion": "json/shield-small.json", "table-plcopen": "json/shield-small.json",
    "laser-stepper": "json/shield-small.json",
}  # fmt: skip


def removed(text: str, machine: Machine) -> str:
    return "".join(line for line in text.splitlines(True) if " MACHINE " not in line)


def allowing_more(text: str, machine: Machine) -> str:
    return text.replace("OUT: cope", "OUT: bevel, cope")


def allowing_none(text: str, machine: Machine) -> str:
    return "".join(line for line in text.splitlines(True) if "LEFT OUT" not in line)


def of_another_form(text: str, machine: Machine) -> str:
    return text.replace(f"BEAMCAM {VERSION}", f"BEAMCAM {VERSION + 1}")


def for_another_machine(text: str, machine: Machine) -> str:
    return text.replace(machine.checksum, "00000000")


def of_no_stock(text: str, machine: Machine) -> str:
    """Without the bar, or for a sheet of another thickness."""
    changed = "".join(line for line in text.splitlines(True) if "BAR " not in line)
    return re.sub(r"SHEET [0-9.]+", "SHEET 77", changed)


def with_a_part_elsewhere(text: str, machine: Machine) -> str:
    return re.sub(r"PART 1 AT -?[0-9.]+", "PART 1 AT 7777", text)


def with_a_larger_part(text: str, machine: Machine) -> str:
    return re.sub(r"(LENGTH|SIZE) [0-9.]+", r"\1 7777", text)


def without_parts(text: str, machine: Machine) -> str:
    return "".join(line for line in text.splitlines(True) if "PART 1 AT" not in line)


CHANGES: tuple[Change, ...] = (
    removed, allowing_more, allowing_none, of_another_form, for_another_machine, of_no_stock,
    with_a_part_elsewhere, with_a_larger_part, without_parts,
)  # fmt: skip


def heads(machines: Sequence[str] = tuple(SAMPLES)) -> Iterator[tuple[str, bool]]:
    """The name of each change to a head, and whether the program was refused for it."""
    for name in machines:
        machine = load(name)
        parts, _ = parts_of([read_file(str(ROOT / "samples" / SAMPLES[name]))])
        for change in CHANGES:
            yield change.__name__, _is_refused(parts, machine, change)


def counted(machines: Sequence[str] = tuple(SAMPLES)) -> tuple[Counter[str], Counter[str]]:
    """How many heads were changed in each way, and how many of the programs were refused."""
    made, caught = Counter[str](), Counter[str]()
    for name, refused in heads(machines):
        made[name] += 1
        caught[name] += refused
    return made, caught


def _is_refused(parts: Any, machine: Machine, change: Change) -> bool:
    row = post_of(machine)

    def emit(program: Any, job: Job) -> Any:
        written = row.emit(program, job)
        if isinstance(written, str):
            return change(written, machine)
        text = change(b"".join(written()).decode("latin-1"), machine)
        return lambda: (text.encode("latin-1"),)

    with patch.object(pipeline, "post_of", lambda _: replace(row, emit=emit)):
        try:
            post(parts, machine, skips=SKIPS)
        except VerifyError as refused:
            return any(said.code == "verify-head" for said in refused.diagnostics)
    return False
