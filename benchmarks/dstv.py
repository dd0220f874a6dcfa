"""How many DSTV files a second one core reads, cross-checks included.

    python benchmarks/dstv.py [FOLDER] [--rounds 100] [--profile]

FOLDER is searched for .nc and .nc1 files; without it the samples of the repository are read. The
files are read from disk once and parsed ROUNDS times; the best of twenty stretches counts, since
other work on the machine only ever makes a stretch slower.
"""

import cProfile
import pstats
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from beamcam.readers.dstv import read
from benchmarks.script import arguments, at_least, start

STRETCHES = 20


def main() -> None:
    parser = arguments(__doc__)
    samples = Path(__file__).parents[1] / "samples" / "dstv"
    parser.add_argument("folder", nargs="?", type=Path, default=samples)
    parser.add_argument("--rounds", type=at_least(1), default=100, help="default 100")
    parser.add_argument("--profile", action="store_true", help="show where the time goes")
    options = parser.parse_args()
    paths = [p for p in options.folder.rglob("*") if p.suffix.lower() in (".nc", ".nc1")]
    files = [(path.read_bytes(), path.name) for path in sorted(paths)]
    if not files:
        parser.error(f"no .nc or .nc1 file in {options.folder}")
    if options.profile:
        with cProfile.Profile() as profile:
            read_all(files, 10)
        pstats.Stats(profile).sort_stats("tottime").print_stats(30)
        return
    rounds = max(1, options.rounds // STRETCHES)
    read_all(files, 1)
    seconds = min(read_all(files, rounds) for _ in range(STRETCHES))
    rate = rounds * len(files) / seconds
    size = sum(len(data) for data, _ in files) / len(files)
    print(f"{len(files)} files of {size:.0f} bytes on average: {rate:.0f} files/s")
    heavy = [name for name in ("numpy", "ezdxf", "ifcopenshell") if name in sys.modules]
    print(f"heavy libraries imported: {', '.join(heavy) or 'none'}")


def read_all(files: list[tuple[bytes, str]], rounds: int) -> float:
    """Seconds of processor time that it takes to read `files`, `rounds` times over."""
    start = time.process_time()
    for _ in range(rounds):
        for data, name in files:
            read(data, name)
    return time.process_time() - start


if __name__ == "__main__":
    start(main)
