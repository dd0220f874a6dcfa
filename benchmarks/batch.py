"""How fast a batch is: files a second, how it grows with workers, and what memory it takes.

    python benchmarks/batch.py [--files 5000] [--jobs 1 2] [--profile PROFILE.txt]

Inputs are beams, channels and struts of their own lengths and holes, written to a temporary
folder (`--folder` to choose the disk). Each figure is the least of `--repeat` runs of a process of
its own, the whole of it: start, reading, planning, posting, reading back, writing.

A fixed loop of plain Python is timed beside every run, so that figures of slow and busy machines
can be read: a file costs so many loops, whatever the machine.
"""

import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from script import arguments, at_least, start

ROOT = Path(__file__).resolve().parent.parent
EACH = ("--bar", "12000", "--each")  #: each part on a bar of its own
BATCH = "import sys; from beamcam.cli import main; main()"
#: Prints the greatest memory of the process itself, in KiB, when the batch is over: getrusage would
#: count that of the benchmark, which it was forked from.
MEASURED = (
    "import atexit, re\n"
    "from beamcam.cli import main\n"
    "status = lambda: open('/proc/self/status').read()\n"
    "atexit.register(lambda: print(re.search(r'VmHWM:\\s+(\\d+)', status())[1]))\n"
    "main()"
)

PROFILES = {
    "I": ("IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    "U": ("UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    "L": ("L100X10", 100.0, 100.0, 10.0, 10.0, 12.0),
}
GAUGES = {"I": (35.0, 115.0), "U": (48.0,), "L": (55.0,)}


def part(number: int, chance: random.Random) -> str:
    """The text of a DSTV file of some 40 lines: a square part with twelve holes."""
    code = chance.choice(sorted(PROFILES))
    name, height, width, flange, web, radius = PROFILES[code]
    length = chance.randrange(1500, 9000)
    sizes = "".join(f"{v:13.2f}\n" for v in (length, height, width, flange, web, radius))
    head = (
        f"ST\n** P{number}.nc1\n  BENCH\n  1\n  1\n  P{number}\n  S355J2\n  1\n  {name}\n  {code}\n"
    )
    rest = "".join(f"{v:13.3f}\n" for v in (42.2, 1.16, 0, 0, 0, 0)) + "\n" * 4
    holes = ["BO\n"]
    faces = "vu" if code == "L" else "vou"
    for k in range(12):
        face = faces[k % len(faces)]
        x = 60 + k * (length - 120) / 12 + chance.randrange(0, 40)
        # On the web about its middle, on a flange on its gauge lines.
        y = height / 2 + chance.choice((-15, 0, 15)) if face == "v" else chance.choice(GAUGES[code])
        holes.append(f"  {face} {x:10.2f}u {y:10.2f} {chance.choice((13, 18, 22)):10.2f}\n")
    return head + sizes + rest + "".join(holes) + "EN\n"


def fill(folder: Path, count: int) -> None:
    """Write `count` parts, the same each time, a thousand to a folder."""
    chance = random.Random(1)
    for number in range(count):
        below = folder / f"{number // 1000:03d}"
        below.mkdir(parents=True, exist_ok=True)
        (below / f"P{number}.nc1").write_text(part(number, chance), encoding="ascii")


class Run(NamedTuple):
    """One batch process."""

    seconds: float
    processor_s: float  #: of it and its workers
    loop_us: float  #: of the loop that was timed before and after it
    printed: str


def batch(source: Path, target: Path, jobs: int, code: str = BATCH) -> Run:
    """A whole batch process into a new folder."""
    shutil.rmtree(target, ignore_errors=True)
    args = ["batch", str(source), "-o", str(target), "--jobs", str(jobs), "-q", *EACH]
    loop = loop_us()
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *args], capture_output=True, text=True, cwd=ROOT, check=False
    )
    seconds, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(done.stderr[-2000:])
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Run(seconds, used, (loop + loop_us()) / 2, done.stdout)


def loop_us() -> float:
    """Processor time of a fixed loop of strings, tuples and dictionaries; the least of several."""
    best = float("inf")
    for _ in range(7):
        begun = time.process_time()
        seen: dict[tuple[str, int], float] = {}
        for n in range(2000):
            word, number = f"X{n * 0.37:.3f}".split(".")
            key = (word, int(number) % 50)
            seen[key] = seen.get(key, 0.0) + float(number)
        best = min(best, time.process_time() - begun)
    return best * 1e6


def process_seconds(args: list[str], repeat: int) -> float:
    """The least time of a whole process."""
    best = float("inf")
    for _ in range(repeat):
        begun = time.perf_counter()
        subprocess.run([sys.executable, *args], check=True, capture_output=True, cwd=ROOT)
        best = min(best, time.perf_counter() - begun)
    return best


def shown(run: Run, files: int, jobs: int, first: Run) -> str:
    """The figures of a run on one line."""
    cost = run.processor_s * 1e6 / files
    return (
        f"{files} files, {jobs} worker(s): {run.seconds:6.2f} s, {files / run.seconds:6.0f} "
        f"files/s, {first.seconds / run.seconds:4.2f} times the first; a file {cost:5.0f} us of "
        f"processor, {cost / run.loop_us:5.3f} loops of {run.loop_us:.0f} us"
    )


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--files", type=at_least(10), default=5000, help="default 5000")
    parser.add_argument("--jobs", type=at_least(1), nargs="+", default=[1, 2], help="default 1 2")
    parser.add_argument("--repeat", type=at_least(1), default=3, help="runs of each; default 3")
    parser.add_argument("--folder", help="where inputs and outputs lie; default the system's")
    parser.add_argument("--profile", help="write where the time of one worker goes, by cProfile")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=chosen.folder) as folder:
        source, target = Path(folder) / "in", Path(folder) / "out"
        fill(source, chosen.files)
        if chosen.profile:
            code = (
                "import cProfile, pstats, sys\nfrom beamcam.cli import main\n"
                "profile = cProfile.Profile()\n"
                "try:\n    profile.runcall(main)\nfinally:\n"
                f"    with open({os.path.abspath(chosen.profile)!r}, 'w') as out:\n"
                "        stats = pstats.Stats(profile, stream=out).sort_stats('tottime')\n"
                "        stats.print_stats(45)\n"
                "        stats.sort_stats('cumtime').print_stats(45)\n"
            )
            batch(source, target, 1, code)
            print(f"profile of {chosen.files} files in {chosen.profile}")
            return
        first: Run | None = None
        for jobs in chosen.jobs:
            runs = [batch(source, target, jobs) for _ in range(chosen.repeat)]
            best = min(runs)
            first = first or best
            print(shown(best, chosen.files, jobs, first))
            least = min(run.processor_s / run.loop_us for run in runs) * 1e6 / chosen.files
            print(f"{'':16}least of {chosen.repeat} runs: a file {least:5.3f} loops of processor")
        begun = time.perf_counter()
        again = [sys.executable, "-c", BATCH, "batch", str(source), "-o", str(target), "-q", *EACH]
        subprocess.run(again, check=True, cwd=ROOT)
        print(f"again, all unchanged:      {time.perf_counter() - begun:6.2f} s")
        shutil.rmtree(source)
        peaks = []
        for count in (chosen.files // 10, chosen.files):
            fill(source, count)
            for jobs in chosen.jobs:
                peak = int(batch(source, target, jobs, MEASURED).printed)
                peaks.append(peak)
                print(f"memory at {count:5d} files, {jobs} worker(s): {peak / 1024:6.1f} MiB")
        click = process_seconds(["-c", "import click"], 10)
        sample = str(ROOT / "samples" / "dstv" / "channel.nc1")
        post = process_seconds(["-m", "beamcam", "post", sample, "-o", "-"], 10)
        print(f"one post: {post * 1000:.0f} ms, {post / click:.1f} times `import click`")


if __name__ == "__main__":
    start(main)
