"""How fast a batch is on a Dask cluster, against as many worker processes.

    python benchmarks/cluster.py [--files 300 3000] [--workers 2] [--folder /dev/shm]

A scheduler and its workers run already, and both ways have posted the files once. Then whole
processes `batch --jobs N` and `batch --scheduler ADDRESS` take turns, from start to end;
the least time of each counts. The programs have to be the same bytes. Needs the extra `dask`.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from batch import ROOT, fill, process_seconds
from script import arguments, at_least, start

PATIENCE_S = 60


@contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process of Dask, until it is no more needed."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    running = subprocess.Popen(
        [sys.executable, "-m", *words], env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield running
    finally:
        running.kill()
        running.wait()


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[str]:
    """The address of a scheduler with workers of one thread each."""
    from distributed import Client

    said = folder / "scheduler.json"
    with ExitStack() as running:
        running.enter_context(
            process("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0",
                    "--no-dashboard", "--scheduler-file", str(said))
        )  # fmt: skip
        for _ in range(workers):
            running.enter_context(
                process("distributed.cli.dask_worker", "--scheduler-file", str(said), "--no-nanny",
                        "--no-dashboard", "--nthreads", "1")
            )  # fmt: skip
        until = time.monotonic() + PATIENCE_S
        while not (said.exists() and said.read_text()):
            if time.monotonic() > until:
                raise SystemExit("the scheduler does not start")
            time.sleep(0.1)
        address: str = json.loads(said.read_text())["address"]
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=PATIENCE_S)
        yield address


def seconds(source: Path, target: Path, *words: str) -> float:
    """The time of a whole batch process into a new folder."""
    args = [sys.executable, "-m", "beamcam", "batch", str(source), "-o", str(target), "-q",
            "--bar", "12000", *words]  # fmt: skip
    begun = time.perf_counter()
    done = subprocess.run(args, capture_output=True, text=True, cwd=ROOT, check=False)
    passed = time.perf_counter() - begun
    if done.returncode:
        raise SystemExit(done.stderr[-2000:])
    return passed


def programs(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*.gcode")}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--files", type=at_least(10), nargs="+", default=[300, 3000])
    parser.add_argument("--workers", type=at_least(1), default=2, help="of both; default 2")
    parser.add_argument("--repeat", type=at_least(1), default=5, help="runs of each; default 5")
    parser.add_argument("--folder", help="where inputs and outputs lie; default the system's")
    chosen = parser.parse_args()
    imported = process_seconds(["-c", "import distributed"], chosen.repeat)
    bare = process_seconds(["-c", "pass"], chosen.repeat)
    print(f"import distributed: {imported - bare:.2f} s")
    with (
        tempfile.TemporaryDirectory(dir=chosen.folder) as place,
        cluster(Path(place), chosen.workers) as address,
    ):
        ways = {"--jobs": ("--jobs", str(chosen.workers)), "Dask": ("--scheduler", address)}
        for files in chosen.files:
            source = Path(place) / f"in-{files}"
            fill(source, files)
            least = dict.fromkeys(ways, float("inf"))
            made: list[dict[str, bytes]] = []
            for number in range(chosen.repeat + 1):
                for way, words in ways.items():
                    target = Path(place) / f"out-{files}-{number}-{way.strip('-')}"
                    passed = seconds(source, target, *words)
                    if number:  # the first of each warms what is kept
                        least[way] = min(least[way], passed)
                    else:
                        made.append(programs(target))
            if made[0] != made[1] or len(made[0]) != files:
                raise SystemExit("the programs are not the same")
            print(
                f"{files} files, {chosen.workers} worker(s): {least['--jobs']:.2f} s by --jobs, "
                f"{least['Dask']:.2f} s by Dask, {least['--jobs'] / least['Dask']:.2f} of the rate"
            )


if __name__ == "__main__":
    start(main)
