"""How beamcam takes damaged inputs: nothing but its own errors, and never too long or too much.

Samples of the five formats and machine files are damaged at random, read, printed as a table and as
JSON, converted, and posted on a machine with the read-back. An input counts as held if it ends in a
program or in a `BeamcamError`; a crash is any other exception, a hang more than 5 s of processor
time, a burst more than 1 GB of memory. Each worker is a process of its own, whose time and memory
the system bounds; where it knows no such bounds (Windows) the parent looks at the clock. What took
too long or too much is tried again alone, in a process that did nothing before: that counts.
With --commands each input goes through two commands instead, chosen at random, as a shell would
call them; programs and configurations are then damaged too.

    python benchmarks/fuzz.py [--inputs 100000] [--seed 1] [--jobs 2] [--formats dstv,json]
    python benchmarks/fuzz.py --commands --inputs 50000 --jobs 1
    python benchmarks/fuzz.py --seed 1 --only 4711 --keep FOLDER

The same seed gives the same inputs. --keep writes each input that did not hold into FOLDER, and
those that the read-back refused.
"""

import multiprocessing
import os
import random
import signal
import sys
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from msgspec import Struct

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks import doors
from benchmarks.damage import damaged
from benchmarks.script import arguments, at_least, start
from benchmarks.uses import HELD, work

ROOT = Path(__file__).resolve().parent.parent
FORMATS = ("dstv", "dxf", "svg", "ifc", "json", "toml")
OF_COMMANDS = (*FORMATS, "program", "config")
MOST_S = 5.0  #: of processor time that an input may take
MOST_BYTES = 1 << 30  #: that it may take beyond what a worker has before
PATIENCE = 6.0  #: times `MOST_S` after which a worker that does not answer is ended
LARGEST_SAMPLE = 60_000  #: bytes; larger ones would only make each step slower

PROGRAMS = (".gcode", ".ngc", ".nc", ".st", ".cnc")
CONFIGURATION = b"""\
machine = "beamline"
stock_lengths = [6000, 12000]
allow_skips = ["cope"]
strict = false
job = "NIGHT"
jobs = 1
name = "{mark}_{quantity}{suffix}"
flat = false
quantity = "file"
[machines]
beam = ["beamline", "beamline-pusher"]
sheet = "plate-linuxcnc"
[tolerances]
merge = 0.1
[sheet]
thickness = 8
kerf = 1.2
lead = "line"
lead_in = 3
copies = [2, 3]
[limits]
pieces = 1000
[map]
red = "cut"
ENGRAVE = { process = "engrave", speed = 300 }
"""

BOUNDS = ("hang", "memory")
FAULTS = ("crash", *BOUNDS)
WARM = 8  #: times that each format goes through commands before the first input
FEW = 5  #: inputs of one fault that are named


class Outcome(Struct):
    """What became of one input."""

    index: int
    format: str
    how: str  #: one of `HELD` or `FAULTS`
    place: str = ""  #: where a fault was, or the codes with which the read-back refused
    seconds: float = 0.0
    megabytes: float = 0.0


class Hang(BaseException):
    """An input took too long. No `Exception`, so that nothing takes it for one of its own."""


def samples(kind: str) -> list[bytes]:
    """The files that are damaged, in the order of their names."""
    if kind == "toml":
        paths = sorted((ROOT / "beamcam" / "machines").glob("*.toml"))
    elif kind == "program":
        found = (ROOT / "tests" / "golden").rglob("*.*")
        paths = sorted(path for path in found if path.suffix in PROGRAMS)
    elif kind == "config":
        return [CONFIGURATION]
    else:
        found = (ROOT / "samples").rglob(f"*{doors.SUFFIXES[kind]}")
        paths = sorted(path for path in found if "bad" not in path.parts)
    return [data for path in paths if len(data := path.read_bytes()) <= LARGEST_SAMPLE]


def input_of(index: int, seed: int, files: dict[str, list[bytes]]) -> tuple[str, bytes]:
    """Format and bytes of an input; the same for the same number and seed."""
    chance = random.Random(f"{seed} {index}")
    kind = tuple(files)[index % len(files)]
    return kind, damaged(chance.choice(files[kind]), chance)


# --- workers --------------------------------------------------------------------------------------


def serve(
    pipe: "Connection[Any, Any]", seed: int, kinds: tuple[str, ...], by_commands: bool
) -> None:
    """Take numbers of inputs and give outcomes, until the pipe is closed."""
    files = {kind: samples(kind) for kind in kinds}
    _warm_up(files, by_commands)
    _bound_memory()
    with suppress(EOFError, OSError):
        while True:
            pipe.send(one(pipe.recv(), seed, files, by_commands))


def one(index: int, seed: int, files: dict[str, list[bytes]], by_commands: bool = False) -> Outcome:
    """What becomes of one input, in this process."""
    use = doors.go_through if by_commands else work
    kind, data = input_of(index, seed, files)
    outcome = Outcome(index, kind, "")
    begun = time.process_time()
    try:
        with _bounded_time():
            outcome.how, outcome.place = use(kind, data, random.Random(f"{seed} {index} machine"))
    except Hang as hang:
        outcome.how, outcome.place = "hang", _place(hang)
    except MemoryError as error:
        outcome.how, outcome.place = "memory", _place(error)
    except Exception as error:
        outcome.how = "crash"
        outcome.place = f"{type(error).__name__} {_place(error)}: {str(error)[:80]}"
    outcome.seconds = time.process_time() - begun
    outcome.megabytes = _peak_megabytes()
    if outcome.how in HELD and outcome.seconds > MOST_S:
        outcome.how, outcome.place = "hang", "seen at its end"
    return outcome


def _warm_up(files: dict[str, list[bytes]], by_commands: bool) -> None:
    """Load what the work needs, so that no input pays for it."""
    use, times = (doors.go_through, WARM) if by_commands else (work, 1)
    for kind, found in files.items():
        with suppress(Exception):
            for seed in range(times):
                use(kind, found[0], random.Random(seed))


def _place(error: BaseException) -> str:
    """The innermost place in beamcam."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if "beamcam" in f.filename and "benchmarks" not in f.filename]
    if not own:
        return "outside"
    path = Path(own[-1].filename)
    return f"{path.parent.name}/{path.name}:{own[-1].lineno} {own[-1].name}"


@contextmanager
def _bounded_time() -> Iterator[None]:
    """Raise `Hang` after `MOST_S` of processor time, where the system can tell."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def stop(*_: object) -> None:
        raise Hang

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, MOST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _bound_memory() -> None:
    """Let this process take `MOST_BYTES` beyond what it has, where the system can tell."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * resource.getpagesize() + MOST_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _peak_megabytes() -> float:
    """The most memory that this process had so far; 0 where the system does not say."""
    try:
        import resource
    except ImportError:
        return 0.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1 << 20) if sys.platform == "darwin" else peak / 1024


def processor_s(process: int | None) -> float:
    """What a process has had of the processor so far, in s; the time by the clock if not known."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError):
        return time.monotonic()


class Worker:
    """A process with one input at a time; one that does not answer is ended and begun anew."""

    def __init__(self, seed: int, kinds: tuple[str, ...], by_commands: bool) -> None:
        self._arguments = (seed, kinds, by_commands)
        self._begin()

    def _begin(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self._process = context.Process(target=serve, args=(other, *self._arguments))
        self._process.start()
        other.close()
        self.index: int | None = None
        self.since = time.monotonic()

    def give(self, index: int) -> None:
        self.index, self.since = index, time.monotonic()
        self._before = processor_s(self._process.pid)
        self.pipe.send(index)

    def take(self) -> Outcome:
        """The outcome of its input; a worker that died over it is replaced."""
        assert self.index is not None
        index, self.index = self.index, None
        try:
            outcome: Outcome = self.pipe.recv()
            return outcome
        except (EOFError, OSError):
            return self._ended(index, "memory", "the worker died")

    def too_late(self) -> Outcome | None:
        """The outcome of an input over which the worker is ended."""
        if self.index is None or self._taken() < PATIENCE * MOST_S:
            return None
        return self._ended(self.index, "hang", "in a library", PATIENCE * MOST_S)

    def _ended(self, index: int, how: str, place: str, seconds: float = 0.0) -> Outcome:
        """The outcome of an input at which the worker is ended and begun anew."""
        self.end()
        self._begin()
        kinds = self._arguments[1]
        return Outcome(index, kinds[index % len(kinds)], how, place, seconds)

    def _taken(self) -> float:
        """Seconds that an input has taken: of the processor, where the system tells, else of the
        clock, by which a busy machine makes a hang of a pause.
        """
        by_clock = time.monotonic() - self.since
        if by_clock < PATIENCE * MOST_S:
            return by_clock
        return processor_s(self._process.pid) - self._before

    def end(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def outcomes(
    indices: range, seed: int, jobs: int, kinds: tuple[str, ...], by_commands: bool = False
) -> Iterator[Outcome]:
    """What becomes of each input, in the order in which they are done."""
    waiting = deque(indices)
    workers = [Worker(seed, kinds, by_commands) for _ in range(min(jobs, len(indices)))]
    try:
        while waiting or any(worker.index is not None for worker in workers):
            for worker in workers:
                if worker.index is None and waiting:
                    worker.give(waiting.popleft())
            busy = {worker.pipe: worker for worker in workers if worker.index is not None}
            for pipe in wait(list(busy), timeout=1.0):
                yield busy[pipe].take()  # type: ignore[index]
            for worker in workers:
                if (late := worker.too_late()) is not None:
                    yield late
    finally:
        for worker in workers:
            worker.end()


def tried_again(
    found: list[Outcome], seed: int, kinds: tuple[str, ...], by_commands: bool = False
) -> list[Outcome]:
    """The outcomes, those of too much time or memory as they are of the input alone."""
    return [
        next(outcomes(range(one.index, one.index + 1), seed, 1, kinds, by_commands))
        if one.how in BOUNDS
        else one
        for one in found
    ]


# --- the table ------------------------------------------------------------------------------------


def table(found: list[Outcome], kinds: tuple[str, ...]) -> Iterator[str]:
    """The counts of each format, the most seconds with the number of their input, and megabytes."""
    words = ("format", "inputs", *HELD, *FAULTS, "most s", "of no.", "most MB")
    yield "".join(f"{word:>10}" for word in words)
    for kind in (*kinds, "all"):
        own = [o for o in found if kind in (o.format, "all")]
        counts = Counter(o.how for o in own)
        slowest = max(own, key=lambda o: o.seconds, default=Outcome(0, kind, ""))
        memory = max((o.megabytes for o in own), default=0.0)
        cells = (kind, len(own), *(counts[how] for how in (*HELD, *FAULTS)))
        yield "".join(f"{cell:>10}" for cell in cells) + (
            f"{slowest.seconds:>10.1f}{slowest.index:>10}{memory:>10.0f}"
        )


def faults(found: list[Outcome]) -> Iterator[str]:
    """Each kind of fault or of refusal by the read-back once, and its first inputs."""
    first: dict[tuple[str, str, str], list[int]] = {}
    for outcome in found:
        if outcome.how in (*FAULTS, "read-back"):
            key = outcome.format, outcome.how, outcome.place
            first.setdefault(key, []).append(outcome.index)
    for (kind, how, place), indices in sorted(first.items(), key=lambda item: -len(item[1])):
        some = ", ".join(map(str, sorted(indices)[:FEW]))
        yield f"{len(indices):6} x {kind} {how}, --only {some}: {place}"


def _kinds(text: str) -> tuple[str, ...]:
    kinds = tuple(text.split(","))
    if not set(kinds) <= set(OF_COMMANDS):
        raise ValueError(text)
    return kinds


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--inputs", type=at_least(1), default=100_000, help="default 100000")
    parser.add_argument("--seed", type=at_least(0), default=1, help="default 1")
    parser.add_argument("--jobs", type=at_least(1), default=2, help="worker processes, default 2")
    parser.add_argument("--formats", type=_kinds, help=",".join(OF_COMMANDS))
    parser.add_argument("--commands", action="store_true", help="go through the commands")
    parser.add_argument("--only", type=at_least(0), help="the number of one input")
    parser.add_argument("--keep", type=Path, help="folder for inputs that did not hold")
    asked = parser.parse_args()
    known = OF_COMMANDS if asked.commands else FORMATS
    asked.formats = asked.formats or known
    if not set(asked.formats) <= set(known):
        parser.error("programs and configurations go through --commands")
    numbers = range(asked.inputs) if asked.only is None else range(asked.only, asked.only + 1)
    found: list[Outcome] = []
    keep = _keeper(asked.keep, asked.seed, asked.formats)
    with suppress(KeyboardInterrupt):  # the table then counts what was done
        for outcome in outcomes(numbers, asked.seed, asked.jobs, asked.formats, asked.commands):
            found.append(outcome)
            if outcome.place or asked.only is not None:
                keep(outcome.index)
    found = tried_again(found, asked.seed, asked.formats, asked.commands)
    print("\n".join((*table(found, asked.formats), *faults(found))))
    if any(outcome.how in FAULTS for outcome in found):
        sys.exit(1)


def _keeper(folder: Path | None, seed: int, kinds: tuple[str, ...]) -> Callable[[int], None]:
    """What writes an input into a folder, if there is one."""
    if folder is None:
        return lambda _: None
    folder.mkdir(parents=True, exist_ok=True)
    files = {kind: samples(kind) for kind in kinds}

    def keep(index: int) -> None:
        kind, data = input_of(index, seed, files)
        (folder / f"{seed}-{index}{doors.SUFFIXES[kind]}").write_bytes(data)

    return keep


if __name__ == "__main__":
    start(main)
