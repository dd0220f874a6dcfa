"""How many parts of copers and tubes are planned, emitted and read back a minute on one core.

    python benchmarks/copers.py [--parts 60]

So many random coped profiles, round and rectangular tubes and profiles that turn, with holes,
slots, windows, copes and skew ends, each posted as `post` does. Processor time, after two parts
that load all modules.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.pipeline import post
from benchmarks.script import arguments, at_least, start
from tests.random_boxes import random_box
from tests.random_copes import random_cope
from tests.random_tubes import random_tube

KINDS = (
    ("coped profiles", "coper-linuxcnc", random_cope),
    ("round tubes", "tube-linuxcnc", random_tube),
    ("rectangular tubes", "tube-linuxcnc", random_box),
    ("profiles that turn", "tube-linuxcnc", random_cope),
)


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--parts", type=at_least(1), default=60, help="of each kind; default 60")
    asked = parser.parse_args()
    for what, name, make in KINDS:
        machine, parts = load(name), [make(seed) for seed in range(asked.parts)]
        made = lines = 0
        spent = 0.0
        for number, part in enumerate((*parts[:2], *parts)):
            begun = time.process_time()
            try:
                text = post((part,), machine).text
            except PlanError:  # a random cope without room
                continue
            if number >= len(parts[:2]):
                spent += time.process_time() - begun
                made, lines = made + 1, lines + text.count("\n")
        rate = 60.0 * made / spent if spent else 0.0
        print(f"{what:18} {made:4} of {asked.parts}, {lines / max(made, 1):5.0f} lines each, "
              f"{rate:6.0f} a minute")  # fmt: skip


if __name__ == "__main__":
    start(main)
