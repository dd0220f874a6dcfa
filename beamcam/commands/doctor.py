"""`beamcam doctor`: what is installed, where settings come from, and whether it works."""

import os
import platform
from collections.abc import Callable, Iterator, Mapping
from importlib import metadata
from time import perf_counter
from typing import Literal

import click
from msgspec import Struct
from msgspec.structs import asdict

from beamcam.commands import options
from beamcam.commands.common import REFUSED, say_json, say_lines
from beamcam.config.load import load as load_config
from beamcam.config.values import CONFIG_NAME, own_files
from beamcam.errors import BeamcamError
from beamcam.machine import shipped
from beamcam.system import user_folder
from beamcam.version import __version__

LIBRARIES = (
    "click", "ezdxf", "ifcopenshell", "jinja2", "manifold3d", "msgspec", "numpy", "shapely",
)  # fmt: skip
#: Extra of beamcam -> what it is for, and the packages that it installs.
EXTRAS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "dask": ("batches on a cluster", ("distributed",)),
    "labels": ("labels for pieces", ("ppf.datamatrix", "reportlab", "segno")),
    "modbus": ("simulate --modbus", ("pymodbus",)),
    "pictures": ("pictures as PNG and PDF", ("pillow", "reportlab")),
    "xlsx": ("lists as spreadsheets", ("openpyxl",)),
}
#: A beam with a hole and a mitre, as a shop's detailer writes it.
BEAM = """ST
** doctor.nc1
  DOCTOR
  1
  1
  D1
  S235JR
  1
  UPN200
  U
      1500.00
       200.00
        75.00
        11.50
         8.50
        11.50
       25.300
        0.661
        0.000
        0.000
        0.000
        0.000




BO
  v  100.00u   60.00   18.00
EN
"""
SHEET = """<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40">
<rect x="5" y="5" width="50" height="30" fill="none" stroke="#000"/></svg>"""

State = Literal["ok", "missing", "fault"]


class Finding(Struct, frozen=True):
    """One thing that was looked at."""

    what: str
    state: State
    text: str


@click.command("doctor")
@options.as_json
def command(as_json: bool) -> None:
    """Print what is installed and where settings come from, and post a sample in memory.

    Exit status 1 if something that beamcam needs does not work; a missing extra is not an
    error. Nothing is written. Send what it prints in with a report of a fault.

    \b
    beamcam doctor
    beamcam doctor --json
    """
    findings = tuple(looked_at())
    if as_json:
        say_json([asdict(one) for one in findings])
    else:
        width = max(len(one.what) for one in findings)
        say_lines(f"{one.what:{width}}  {one.state:7}  {one.text}" for one in findings)
    if any(one.state == "fault" for one in findings):
        raise SystemExit(REFUSED)


def looked_at() -> Iterator[Finding]:
    """All that there is to know, what is wrong included."""
    folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    yield Finding("beamcam", "ok", f"{__version__} in {folder}")
    system = f"{platform.system()} {platform.release()} {platform.machine()}"
    yield Finding("python", "ok", f"{platform.python_version()} on {system}")
    for name in LIBRARIES:
        version = _version(name)
        yield Finding(name, "ok" if version else "fault", version or "expected it to be installed")
    for extra, (use, packages) in EXTRAS.items():
        missing = [name for name in packages if not _version(name)]
        how = f"pip install 'beamcam[{extra}]'" if missing else "is there"
        yield Finding(f"extra {extra}", "missing" if missing else "ok", f"{use}: {how}")
    try:
        for path in (own := own_files()):
            load_config(path)
        places = f"none; looked for {CONFIG_NAME} here and above, then in {user_folder()}"
        text = ", ".join(map(os.path.abspath, own)) or places
        yield Finding("configuration", "ok", text)
    except BeamcamError as error:
        yield Finding("configuration", "fault", str(error.diagnostics[0]))
    yield Finding("machines", "ok", f"{len(shipped())} shipped: {', '.join(shipped())}")
    yield _tried("a beam", lambda: _posted(BEAM, "doctor.nc1", "beamline"))
    yield _tried("a drawing", lambda: _posted(SHEET, "doctor.svg", "plate-linuxcnc"))


def _version(package: str) -> str:
    """The version of an installed package; "" where it is not."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""


def _tried(what: str, work: Callable[[], int]) -> Finding:
    """Whether some work can be done here, and how long it takes."""
    begun = perf_counter()
    try:
        lines = work()
    except Exception as error:  # a library that is broken may raise anything
        return Finding(what, "fault", f"{type(error).__name__}: {error}")
    took = 1000 * (perf_counter() - begun)
    return Finding(what, "ok", f"posted and read back, {lines} lines in {took:.0f} ms")


def _posted(text: str, name: str, machine: str) -> int:
    """The lines of the program of a part. Raises BeamcamError."""
    from beamcam.machine import load
    from beamcam.machine.overlay import with_torch
    from beamcam.pipeline import parts_of, post
    from beamcam.readers import read

    parts, _ = parts_of([read(text.encode(), name)])
    made_on = load(machine)
    if made_on.torch is not None:
        made_on = with_torch(made_on, thickness=3.0)
    return len(post(parts, made_on).text.splitlines())
