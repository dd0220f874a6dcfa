"""What the commands do with a damaged input, in this process, as a shell would call them."""

import io
import os
import random
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

from benchmarks.uses import SUFFIXES as PART_SUFFIXES

ROOT = Path(__file__).resolve().parent.parent
SUFFIXES = {**PART_SUFFIXES, "program": ".gcode", "config": ".toml"}
AT_ONCE = 2  #: commands that one input goes through

BEAM = str(ROOT / "samples/dstv/channel.nc1")
PLATE = str(ROOT / "samples/dstv/gusset.nc1")
PROGRAM = str(ROOT / "tests/golden/beamline/channel.gcode")

#: The commands by what they take: IN is the input, OUT a folder for what is written.
OF_PARTS = (
    "inspect IN", "inspect IN --json", "inspect IN --check", "convert IN -o OUT/x.json",
    "convert IN -o OUT/x.dxf", "convert IN -o OUT/all/ --to nc1", "post IN -o OUT/x.gcode",
    "post IN -o OUT/x.gcode --quantity file --bar 12000 --allow-skips all",
    "post IN -o OUT/x.ngc --thickness 3 --machine plate-linuxcnc",
    "post IN -o OUT/x.gcode --turn --order best --machine beamline-pusher",
    "post IN -o OUT/x.st --thickness 3 --machine table-simotion",
    "plan IN", "plan IN --json --thickness 3", "plan IN --quantity file",
    "plot IN -o OUT/x.svg", "plot IN -o OUT/x.png", "plot IN -o OUT/x.pdf",
    "report IN -o OUT/x.html --thickness 3", "report IN -o OUT/x.pdf --quantity file",
    "list IN --bar 12000", "list IN -o OUT/x.xlsx --quantity file", "list IN -o OUT/x.json",
    "labels IN -o OUT/x.pdf", "labels IN -o OUT/x.zpl --code datamatrix",
    "batch IN -o OUT/all --quantity file", "batch IN -o OUT/all --thickness 3 --allow-skips all",
    f"diff IN {BEAM}", f"diff {PLATE} IN", f"verify {PROGRAM} --against IN",
)  # fmt: skip
OF_PROGRAMS = (
    "verify IN", f"verify IN --against {BEAM}", f"verify IN --against {PLATE}",
    "recover IN -o OUT/x.nc1", "recover IN -o OUT/x.json", f"diff IN {PROGRAM}",
    "plot IN -o OUT/x.svg", "plot IN -o OUT/x.png", "report IN -o OUT/x.html",
    "report IN -o OUT/x.pdf", f"report IN {BEAM} -o OUT/x.html", "simulate IN -o OUT/x.csv",
    "simulate IN -o OUT/x.json",
)  # fmt: skip
COMMANDS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("dstv", "dxf", "svg", "ifc", "json"), OF_PARTS),
    "program": OF_PROGRAMS,
    "toml": (
        "machines show IN", "machines check IN", f"post {BEAM} -o OUT/x.gcode --machine IN",
        f"post {PLATE} -o OUT/x.ngc --machine IN", f"plan {BEAM} --machine IN",
        f"verify {PROGRAM} --machine IN", f"simulate {PROGRAM} -o OUT/x.csv --machine IN",
        f"recover {PROGRAM} -o OUT/x.nc1 --machine IN",
    ),
    "config": (
        "config --config IN", "config --config IN --json",
        f"post {BEAM} -o OUT/x.gcode --config IN", f"post {PLATE} -o OUT/x.ngc --config IN",
        f"batch {BEAM} {PLATE} -o OUT/all --config IN", f"list {BEAM} {PLATE} --config IN",
        f"labels {BEAM} -o OUT/x.zpl --config IN", f"verify {PROGRAM} --config IN",
        f"plan {PLATE} --config IN",
    ),
}  # fmt: skip


def go_through(kind: str, data: bytes, chance: random.Random) -> tuple[str, str]:
    """Give an input to commands that are chosen at random; what came of the last, and "".

    Raises any exception that a command lets through.
    """
    from beamcam.cli import main

    how = "refused"
    for line in chance.sample(COMMANDS[kind], AT_ONCE):
        with tempfile.TemporaryDirectory() as folder, _quiet(), _inside(folder):
            path = Path(folder) / f"input{_suffix(kind, data)}"
            path.write_bytes(data)
            places = {"IN": str(path), "OUT": folder}
            words = [_placed(word, places) for word in line.split()]
            try:
                main(words, prog_name="beamcam")
            except SystemExit as end:
                how = "refused" if end.code else "posted"
    return how, ""


def _placed(word: str, places: Mapping[str, str]) -> str:
    first, slash, rest = word.partition("/")
    return places[first] + slash + rest if first in places else word


def _suffix(kind: str, data: bytes) -> str:
    """The suffix of an input: that of its program, of which some are told by it alone."""
    if kind != "program":
        return SUFFIXES[kind]
    if data[:400].find(b"UNIT") >= 0 or b"PROGRAM" in data[:400]:
        return ".st"
    return ".gcode"


@contextmanager
def _quiet() -> Iterator[None]:
    """Nothing of what a command prints is seen."""
    out, said = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))
    with redirect_stdout(out), redirect_stderr(said):
        yield


@contextmanager
def _inside(folder: str) -> Iterator[None]:
    """A command called in a folder."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
