"""How fast models are read: members a second, the cost beside opening the file, memory.

Each is read on one core, and as the commands do it, on all; times are those of the clock. The
garbage collector is tuned as in the commands, for `ifcopenshell.open` too. The last column is the
ratio of whole processes by their processor time, the least of several runs by turns: `beamcam
inspect --no-check` beside one that opens the file and no more.

    python benchmarks/ifc.py [MODEL...]

Without a model it makes some: one as Tekla writes it, and bare members with holes by a boolean
chain, by openings and as Breps. Each is read in a process of its own.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.script import arguments, start  # noqa: E402

MEMBERS = {"tekla": 3000, "csg": 1000, "openings": 1000, "outline": 1000, "brep": 60}
REPEATS = 3


def made(encoding: str, count: int, folder: Path) -> Path:
    """A model of `count` members in one encoding."""
    from benchmarks.make_model import model
    from tests.property.ifc_builder import model_text, random_member

    path = folder / f"{encoding}.ifc"
    if encoding == "tekla":
        path.write_text(model(count), encoding="utf-8")
        return path
    random = Random(encoding)
    members = [random_member(random, encoding) for _ in range(count)]
    path.write_text(model_text(members, encoding, random)[0], encoding="utf-8")
    return path


def measure(path: Path) -> dict[str, float]:
    """Seconds of opening and of reading, the members read, and the memory that took."""
    import ifcopenshell

    from beamcam.readers.ifc import Options, read
    from beamcam.system import collector_seldom, cores

    collector_seldom()
    data = path.read_bytes()
    opened, alone, shared = [], [], []
    for _ in range(REPEATS):
        start = time.perf_counter()
        file = ifcopenshell.open(str(path))
        opened.append(time.perf_counter() - start)
        del file
        for took, workers in ((alone, 1), (shared, cores())):
            start = time.perf_counter()
            reading = read(data, str(path), options=Options(workers=workers))
            took.append(time.perf_counter() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {
        "members": len(reading.parts),
        "open_s": min(opened),
        "alone_s": min(alone),
        "shared_s": min(shared),
        "peak_mb": peak,
    }


def in_own_process(path: Path) -> dict[str, float]:
    command = [sys.executable, __file__, "--one", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    row: dict[str, float] = json.loads(done.stdout)
    return row


def processes(path: Path) -> float:
    """How many times as long as one that opens the model a process takes that reads it."""
    opening = f"import ifcopenshell; ifcopenshell.open({str(path)!r})"
    reading = ["-m", "beamcam", "inspect", "--no-check", str(path)]
    took: tuple[list[float], list[float]] = ([], [])
    for _ in range(REPEATS):
        for seconds, asked in zip(took, (["-c", opening], reading), strict=True):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, *asked], cwd=ROOT, capture_output=True, check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds.append(sum(after[:2]) - sum(before[:2]))
    return min(took[1]) / min(took[0])


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("models", nargs="*", type=Path, metavar="MODEL")
    parser.add_argument("--one", type=Path, help="read one model and print its row as JSON")
    asked = parser.parse_args()
    if asked.one:
        print(json.dumps(measure(asked.one)))
        return
    print(
        "model              MB  members  open s  read s  ratio  all cores  ratio  members/s peak MB"
        "  processes"
    )
    with tempfile.TemporaryDirectory() as folder:
        for path in asked.models or [made(*row, Path(folder)) for row in MEMBERS.items()]:
            row = in_own_process(path)
            alone, shared = (row[key] / row["open_s"] for key in ("alone_s", "shared_s"))
            print(
                f"{path.name[:17]:17} {path.stat().st_size / 1e6:5.1f} {row['members']:8.0f}"
                f" {row['open_s']:7.3f} {row['alone_s']:7.3f} {alone:6.1f}"
                f" {row['shared_s']:10.3f} {shared:6.1f}"
                f" {row['members'] / row['shared_s']:10.0f} {row['peak_mb']:7.0f}"
                f" {processes(path):10.1f}"
            )


if __name__ == "__main__":
    start(main)
