"""Programs of sample bars, and what the third opinion says of them."""

from functools import cache

from msgspec.structs import replace

from beamcam.errors import Severity, Source
from beamcam.machine import load
from beamcam.model.part import EndCuts, Hole, Part, Profile
from beamcam.model.request import Request
from beamcam.pipeline import parts_of, post, read_file
from beamcam.solid.opinion import solid_faults
from tests.conftest import ROOT

SRC = Source("bar.nc1", 1)
#: Nothing of it is symmetric: an angle with a mitre, holes in both legs, one of them blind.
ODD = Part(
    "ODD", Profile("L", "L120X80X10", 120.0, 80.0, 10.0, 10.0, 0.0), 900.0, SRC,
    cuts=EndCuts(web_end=20.0),
    features=(
        Hole("v", 80.0, 70.0, 18.0, SRC),
        Hole("v", 300.0, 90.0, 14.0, SRC, depth=6.0, kind="blind"),
        Hole("u", 200.0, 50.0, 18.0, SRC),
    ),
)  # fmt: skip


@cache
def sample(*names: str) -> tuple[Part, ...]:
    return parts_of(read_file(str(ROOT / f"samples/dstv/{n}.nc1")) for n in names)[0]


@cache
def posted(parts: tuple[Part, ...], machine: str = "beamline", bar: float | None = None) -> str:
    return post(parts, load(machine), bar=bar, skips=("all",)).text


def codes(
    text: str, parts: tuple[Part, ...], machine: str = "beamline", bar: float | None = None,
    skips: tuple[str, ...] = (),
) -> list[str]:  # fmt: skip
    """The codes of all that is no note."""
    said = solid_faults(text, Request(parts, load(machine), skips), bar)
    return [d.code for d in said if d.severity is not Severity.NOTE]


def told(text: str, parts: tuple[Part, ...], machine: str = "beamline") -> str:
    return "\n".join(map(str, solid_faults(text, Request(parts, load(machine)))))


def mirrored(part: Part) -> Part:
    """The part as a mirror along its length shows it: the ends and their angles change places."""
    c = part.cuts
    features = tuple(replace(f, x=part.length - f.x) for f in part.holes)
    cuts = EndCuts(-c.web_end, -c.web_start, -c.flange_end, -c.flange_start)
    return replace(part, features=features, cuts=cuts)
