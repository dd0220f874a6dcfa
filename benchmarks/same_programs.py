"""Whether two checkouts of beamcam make the same programs, byte for byte, and say the same.

    python benchmarks/same_programs.py OLD_TREE NEW_TREE samples [folder or file ...]

Every input is posted with every machine as it is, with all that may be left out left out, and with
parts turned and ordered as is best; parts of one section are laid on one bar with those of the file
before. Programs, messages and the explained plan are compared, and each difference is printed.
"""

import difflib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from script import arguments, start

VARIANTS: dict[str, dict[str, Any]] = {
    "": {},
    "skips": {"skips": ("all",)},
    "best": {"skips": ("all",), "order": "best", "turn": True},
}
SHOWN_LINES = 12  #: of a difference


class Result(NamedTuple):
    """What one checkout made of one input on one machine."""

    what: str  #: file, machine and variant
    texts: dict[str, str]  #: program, messages and explanation


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("old", type=Path, help="checkout before the change")
    parser.add_argument("new", type=Path, help="checkout with it")
    parser.add_argument("inputs", type=Path, nargs="+", help="files, and folders of files")
    parser.add_argument("--machine", action="append", help="instead of all that are shipped")
    parser.add_argument("--worker", action="store_true", help="print what NEW_TREE makes, as JSON")
    asked = parser.parse_args()
    files = sorted({file for path in asked.inputs for file in _files(path)})
    if asked.worker:
        for result in _results(files, asked.machine):
            print(json.dumps(result), flush=True)
        return
    options = [f"--machine={machine}" for machine in asked.machine or ()]
    olds, news = (
        {one.what: one.texts for one in _read(tree.resolve(), files, options)}
        for tree in (asked.old, asked.new)
    )
    both = [what for what in olds if what in news]
    made = sum(bool(olds[what]["program"]) for what in both)
    others = sum(olds[what]["program"] != news[what]["program"] for what in both)
    different = [what for what in both if olds[what] != news[what]]
    for what in different:
        print("\n".join(_difference(what, olds[what], news[what])))
    for tree, own, other in ((asked.old, olds, news), (asked.new, news, olds)):
        for what in own:
            if what not in other:
                print(f"{what}: by {tree} alone")
    print(f"{len(files)} files: {made} programs made, {len(both) - made} refused; "
          f"{len(different)} differences, {others} of programs; {len(olds) - len(both)} results by "
          f"{asked.old} alone, {len(news) - len(both)} by {asked.new} alone")  # fmt: skip
    sys.exit(1 if different or olds.keys() != news.keys() else 0)


def _files(path: Path) -> Iterator[Path]:
    """The files of a folder and those below it, or the file."""
    yield from (p for p in path.rglob("*") if p.is_file()) if path.is_dir() else (path,)


def _read(tree: Path, files: Sequence[Path], options: Sequence[str]) -> Iterator[Result]:
    """What the beamcam of a checkout makes of the files, one after the other."""
    command = [sys.executable, __file__, str(tree), str(tree), *map(str, files), "--worker"]
    environment = os.environ | {"PYTHONPATH": str(tree), "PYTHONHASHSEED": "0"}
    with subprocess.Popen(
        [*command, *options], stdout=subprocess.PIPE, env=environment, text=True, encoding="utf-8"
    ) as worker:
        assert worker.stdout is not None
        for line in worker.stdout:
            yield Result(*json.loads(line))
    if worker.returncode:
        sys.exit(f"{tree}: the worker ended with {worker.returncode}")


def _results(files: Sequence[Path], names: Sequence[str] | None) -> Iterator[Result]:
    """What this beamcam makes of the files on every machine."""
    from beamcam.errors import BeamcamError
    from beamcam.machine import load, shipped
    from beamcam.pipeline import read_file

    machines = [load(name) for name in names or sorted(shipped())]
    before: tuple[Any, ...] = ()
    for file in files:
        try:
            parts = read_file(str(file)).parts
        except BeamcamError as error:
            yield Result(f"{file} is not read", {"program": "", "messages": str(error)})
            continue
        for machine in machines:
            is_bar = machine.stock == "beam"
            for variant, options in VARIANTS.items() if is_bar else [("", {})]:
                what = f"{file} on {machine.name} {variant}".strip()
                yield Result(what, _post(parts, machine, options))
            if is_bar and before and parts and parts[0].profile == before[0].profile:
                what = f"{file} behind the one before on {machine.name}"
                yield Result(what, _post((*before, *parts), machine, VARIANTS["best"]))
        before = parts


def _post(parts: Any, machine: Any, options: dict[str, Any]) -> dict[str, str]:
    """Program, messages and explanation of parts on a machine."""
    from beamcam.errors import BeamcamError
    from beamcam.pipeline import post
    from beamcam.planning.explain import explain

    try:
        posted = post(parts, machine, "SAME", **options)
    except BeamcamError as error:
        return {"program": "", "messages": "\n".join(map(str, error.diagnostics))}
    texts = {"program": posted.text, "messages": "\n".join(map(str, posted.remarks))}
    if machine.stock == "beam":
        texts["explanation"] = repr(explain(posted.plan, machine)).replace("Step(", "\nStep(")
    return texts


def _difference(what: str, old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    """The lines that tell how two results differ."""
    for name in {**old, **new}:
        mine, theirs = old.get(name, ""), new.get(name, "")
        if mine != theirs:
            yield f"{what}: {name}"
            lines = difflib.unified_diff(mine.splitlines(), theirs.splitlines(), n=0, lineterm="")
            yield from ("    " + line for line in list(lines)[2 : 2 + SHOWN_LINES])


if __name__ == "__main__":
    start(main)
