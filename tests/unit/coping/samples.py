"""Parts and programs of the coper for the tests."""

from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, Feature, Part, Profile
from beamcam.model.request import Job, Request
from beamcam.pipeline import post, read_file
from tests.conftest import SAMPLES
from tests.random_copes import polygon

AT = Source("part.nc1", 7)
COPER = load("coper-linuxcnc")
NAMES = ("coped", "trimmer", "cleat", "hanger", "joist")
IPE300 = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
UPN200 = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
L100 = Profile("L", "L100*65*8", 100.0, 65.0, 8.0, 8.0, 10.0)


def sample(name: str) -> Part:
    """The part of a sample."""
    (part,) = read_file(str(SAMPLES / "coping" / f"{name}.nc1")).parts
    return part


def part_of(*features: Feature, profile: Profile = IPE300, length: float = 600.0) -> Part:
    """A part with some features."""
    return Part("P1", profile, length, AT, features=features, grade="S235JR")


def outline(face: str, points: list[tuple[float, float]], kind: str = "outer") -> Contour:
    """A contour of straight lines."""
    return Contour(face, kind, polygon(points), AT)  # type: ignore[arg-type]


def with_keys(**keys: object) -> Machine:
    """The coper with other keys."""
    assert COPER.coper is not None
    return replace(COPER, coper=replace(COPER.coper, **keys))


_PROGRAMS: dict[tuple[str, str], str] = {}


def program_of(part: Part, machine: Machine = COPER) -> str:
    """The program of a part, read back; many tests ask for the same."""
    key = repr(part), repr(machine)
    if key not in _PROGRAMS:
        _PROGRAMS[key] = post((part,), machine, "JOB").text
    return _PROGRAMS[key]


def faults(text: str, part: Part, machine: Machine = COPER) -> tuple[Diagnostic, ...]:
    """What the read-back says of a program; of one that `program_of` gave it has passed."""
    if text == _PROGRAMS.get((repr(part), repr(machine))):
        return ()
    return errors_in(verify_coping(text, (part,), machine, (), "JOB"))


def job_of(part: Part, machine: Machine = COPER) -> Job:
    """A part as a job by itself."""
    return Job(Request((part,), machine, name="JOB"), (0,))
