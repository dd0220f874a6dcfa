"""What is done with a damaged input: all that the commands do with a file, one after the other."""

import random
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from beamcam.errors import BeamcamError, VerifyError

ROOT = Path(__file__).resolve().parent.parent
SUFFIXES = {
    "dstv": ".nc1", "dxf": ".dxf", "svg": ".svg", "ifc": ".ifc", "json": ".json", "toml": ".toml",
}  # fmt: skip
BARS = ("beamline", "beamline-annex", "beamline-pusher")
SHEETS = (
    "plate-linuxcnc",
    "plate-codesys",
    "laser-grbl",
    "table-simotion",
    "table-plcopen",
    "laser-stepper",
)
MOST_PARTS = 2  #: of a file that are posted

HELD = ("posted", "refused", "read-back")


def work(kind: str, data: bytes, chance: random.Random) -> tuple[str, str]:
    """Do with an input all that the commands do; one of `HELD`, and the codes of the read-back.

    Raises any exception that is not our own.
    """
    try:
        if kind == "toml":
            _use_machine(data)
        else:
            _use_parts(f"input{SUFFIXES[kind]}", data, chance)
    except VerifyError as error:
        return "read-back", " ".join(sorted({said.code for said in error.diagnostics}))
    except BeamcamError:
        return "refused", ""
    return "posted", ""


def _use_machine(data: bytes) -> None:
    """Load a machine file, and post a sample with it."""
    from beamcam.arguments import load_tested

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mine.toml"
        path.write_bytes(data)
        machine = load_tested(str(path))
    sample = "channel" if machine.stock == "beam" else "plate"
    _post(f"{sample}.nc1", (ROOT / f"samples/dstv/{sample}.nc1").read_bytes(), machine)


def _use_parts(name: str, data: bytes, chance: random.Random) -> None:
    from beamcam.machine import load
    from beamcam.model import part_json
    from beamcam.model.part_json import part_to_json
    from beamcam.readers import read
    from beamcam.reports.tables import part_table
    from beamcam.writers import dstv, faces_dxf

    reading = read(data, name)
    for said in reading.diagnostics:
        str(said)
    for part in reading.parts[:MOST_PARTS]:
        list(part_table(part))
        part_to_json(part)
        if reading.refused or part.length <= 0.0 or not part.profile.height:
            continue  # as `convert` does
        again = read(part_json.write(part).encode(), "again.json")
        if again.refused:
            raise AssertionError(f"the JSON form is refused: {again.diagnostics[0]}")
        for writer in (dstv, faces_dxf):
            with suppress(BeamcamError):
                writer.write(part)
    if reading.refused or not reading.parts:
        raise BeamcamError(reading.diagnostics)
    sheet = reading.parts[0].profile.code == "B"
    _post(name, data, load(chance.choice(SHEETS if sheet else BARS)))


def _post(name: str, data: bytes, machine: Any) -> None:
    """Post the first parts of a file, all of a sheet cut."""
    from beamcam.machine.overlay import with_torch
    from beamcam.model.part import Contour
    from beamcam.model.plan import SKIP_NAMES
    from beamcam.pipeline import post
    from beamcam.readers import read

    parts = read(data, name).parts[:MOST_PARTS]
    if machine.torch is not None:
        machine = with_torch(machine, {"red": "cut"})
        parts = tuple(
            replace(
                part,
                features=tuple(
                    replace(f, layer=None, colour="#ff0000") if isinstance(f, Contour) else f
                    for f in part.features
                ),
            )
            for part in parts[:1]
        )
    posted = post(parts, machine, skips=SKIP_NAMES)
    for _ in posted.pieces():
        pass
