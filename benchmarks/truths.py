"""Which test sees that a fixed truth is untrue.

Planner and read-back share `model/`, `machine/`, `geometry/` and the shipped machine files, so that
neither finds fault with them. Each of the edits in `truths.txt` makes one of these truths untrue in
a copy of the project; then tests/truths is run there, which compares nothing that is posted with a
golden file. Each has to be seen.

    python benchmarks/truths.py [--only WORD] [--jobs 2]
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue

from msgspec import Struct
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks.script import arguments, at_least, start

ROOT = Path(__file__).resolve().parent.parent
COPIED = ("beamcam", "samples", "tests", "pyproject.toml")
#: The quick ones first, as the first failure ends a run.
TESTS = ("sections", "tools", "machines", "curves", "motion", "letters", "ends", "units", "bars",
         "sheets", "solids")  # fmt: skip
SECONDS = 120  #: that a run may take


class Edit(Struct, frozen=True):
    """One line of a file made untrue."""

    what: str
    path: str  #: in `beamcam/`
    old: str  #: stands there once
    new: str


def edits() -> list[Edit]:
    """The edits of `truths.txt`: a line with file and name, what is there, what shall be."""
    found: list[Edit] = []
    for line in (ROOT / "benchmarks" / "truths.txt").read_text(encoding="utf-8").splitlines():
        sign, text = line[:2], line[2:]
        if sign not in ("- ", "+ "):
            path, what = line.split(": ", 1)
            found.append(Edit(what, path, "", ""))
            continue
        last = found[-1]
        key, before = ("old", last.old) if sign == "- " else ("new", last.new)
        found[-1] = replace(last, **{key: f"{before}\n{text}" if before else text})
    return found


_FAILED = re.compile(r"^(?:FAILED|ERROR) tests/truths/(\S+)", re.MULTILINE)


def edited(text: str, edit: Edit) -> str:
    """The text of a file with an edit made. Raises ValueError unless there is one place."""
    if text.count(edit.old) != 1:
        raise ValueError(
            f"{edit.what}: found {text.count(edit.old)} times in beamcam/{edit.path}, expected "
            f"once: {edit.old!r}"
        )
    return text.replace(edit.old, edit.new)


def copy_to(folder: Path) -> None:
    """The project as it is, with what is compiled of it."""
    for name in COPIED:
        path = ROOT / name
        if path.is_dir():
            shutil.copytree(path, folder / name, ignore=shutil.ignore_patterns(".*"))
        else:
            shutil.copy2(path, folder / name)


def seen_by(copy: Path, edit: Edit | None) -> str:
    """The test that fails first in a copy with an edit; "" if none does."""
    if edit is None:
        return _first_failure(copy)
    path = copy / "beamcam" / edit.path
    before = path.read_text(encoding="utf-8")
    try:
        path.write_text(edited(before, edit), encoding="utf-8")
        for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*"):
            compiled.unlink()
        return _first_failure(copy)
    finally:
        path.write_text(before, encoding="utf-8")


def _first_failure(copy: Path) -> str:
    tests = [f"tests/truths/test_{name}.py" for name in TESTS]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "-n", "0", "-p", "no:cacheprovider", "-rfE",
         "--tb", "no", *tests],
        cwd=copy, capture_output=True, text=True, timeout=SECONDS, check=False,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(copy)},
    )  # fmt: skip
    if done.returncode == 0:
        return ""
    found = _FAILED.search(done.stdout)
    return found[1] if found else f"a run that ended with {done.returncode}"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only", default="", help="edits whose name or file has this word")
    parser.add_argument(
        "--jobs", type=at_least(1), default=2, help="copies that are tested at once"
    )
    given = parser.parse_args()
    chosen = [e for e in edits() if given.only in e.what or given.only in e.path]
    with tempfile.TemporaryDirectory() as folder:
        copies: Queue[Path] = Queue()
        for k in range(given.jobs):
            copy_to(Path(folder) / str(k))
            copies.put(Path(folder) / str(k))

        def run(edit: Edit | None) -> str:
            copy = copies.get()
            try:
                return seen_by(copy, edit)
            finally:
                copies.put(copy)

        if wrong := run(None):
            sys.exit(f"without an edit: {wrong} fails")
        unseen = 0
        with ThreadPoolExecutor(given.jobs) as pool:
            for edit, test in zip(chosen, pool.map(run, chosen), strict=True):
                unseen += not test
                print(f"{edit.what:38} beamcam/{edit.path:32} {test or 'NOT SEEN'}")
    print(f"\n{len(chosen) - unseen} of {len(chosen)} seen")
    sys.exit(unseen > 0)


if __name__ == "__main__":
    start(main)
