"""Which files a batch is about: folders, patterns and files in, a list of inputs out.

    jobs/A/M1.nc1  jobs/B/M1.nc1     two files: the folder they share is jobs,
         \\_ tree A/M1.nc1  \\_ B/M1.nc1    and below it their names differ

A folder gives the files below it whose suffix a reader knows, in order of their names; what
starts with a dot is left alone. A file met twice is taken once.
"""

import glob
import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress

from msgspec import Struct

from beamcam.batch import FOLDER, LOOP, NOTHING
from beamcam.config.values import CONFIG_NAME
from beamcam.errors import Diagnostic, Source
from beamcam.readers import FORMATS, STANDARD_INPUT, UNREADABLE, content

#: Suffixes of the inputs of a batch.
SUFFIXES = tuple(suffix for known in FORMATS for suffix in known.suffixes)


class Input(Struct, frozen=True):
    """One file of a batch."""

    path: str  #: as it was named, or found below a folder that was
    tree: str  #: its path below the folder that all inputs share, with "/"


class FoundInputs(Struct, frozen=True):
    """The inputs in order, and remarks on where they were looked for."""

    inputs: tuple[Input, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    configurations: tuple[str, ...] = ()  #: that lie in the folders looked through


def find_inputs(names: Sequence[str], leave_out: Collection[str] = ()) -> FoundInputs:
    """The files that `names` stand for, below folders without those below `leave_out`."""
    diagnostics: list[Diagnostic] = []
    configurations: list[str] = []
    places: list[tuple[str, str]] = []  # path, and the folder that it was looked for in
    without = {identity for path in leave_out if (identity := _identity(path)) is not None}
    for name in names:
        before = len(places), len(diagnostics)
        paths, root = [name], name if os.path.isdir(name) else os.path.dirname(name)
        if not os.path.lexists(name) and glob.has_magic(name):
            paths = sorted(glob.glob(name, recursive=True))
            while glob.has_magic(root):
                root = os.path.dirname(root)
        for path in paths:
            if os.path.isdir(path):
                parents: list[tuple[tuple[int, int], str]] = []  # identity and path of each
                real = os.path.realpath(path)
                while (place := os.path.dirname(real)) != real:
                    parents.append((_identity(place) or (-1, -1), place))
                    real = place
                below = _walk(path, without, diagnostics, configurations, parents)
                places += ((inner, root) for inner in below)
            else:
                places.append((path, root))
        if (len(places), len(diagnostics)) == before:
            diagnostics.append(NOTHING.at(Source(name), found=name))
    return FoundInputs(
        tuple(_inputs(places)), tuple(diagnostics), tuple(dict.fromkeys(configurations))
    )


def _inputs(places: Iterable[tuple[str, str]]) -> Iterator[Input]:
    """The inputs, each once, with their paths below the folder that all of them share."""
    places = list(places)
    base = ""  # where they share none, as on two drives
    with suppress(ValueError):
        base = os.path.commonpath([os.path.abspath(one) for one in {one for _, one in places}])
    seen: set[str] = set()
    below: dict[str, tuple[str, str]] = {}  # folder of a file -> its absolute path, and below base
    for path, _ in places:
        folder, name = os.path.split(path)
        if folder not in below:
            whole = os.path.abspath(folder)
            relative = os.path.relpath(whole, base) if base else ""
            below[folder] = whole, "" if relative == os.curdir else relative.replace(os.sep, "/")
        whole, relative = below[folder]
        if (whole_path := os.path.join(whole, name)) not in seen:
            seen.add(whole_path)
            yield Input(path, f"{relative}/{name}" if relative else name)


def _identity(path: str) -> tuple[int, int] | None:
    try:
        status = os.stat(path)
    except OSError:
        return None  # what is not there cannot be met
    return status.st_dev, status.st_ino


def _walk(
    folder: str, without: Collection[tuple[int, int]], diagnostics: list[Diagnostic],
    configurations: list[str], parents: Sequence[tuple[tuple[int, int], str]],
    above: tuple[tuple[tuple[int, int], str], ...] = (),
) -> Iterator[str]:  # fmt: skip
    """The files below a folder, in order of their names; links are followed, but never back.

    `above` are the folders come through, `parents` those above the first of them.
    """
    identity = _identity(folder) or (0, 0)
    back = [path for known, path in (*above, *(parents if above else ())) if known == identity]
    if back:
        diagnostics.append(LOOP.at(Source(folder), found=back[0]))
        return
    if above and identity in without:  # a folder that is named is meant
        return
    try:
        with os.scandir(folder) as listing:
            entries = sorted(listing, key=lambda entry: entry.name)
    except OSError as error:
        diagnostics.append(FOLDER.at(Source(folder), found=error.strerror or error))
        return
    for entry in entries:
        if entry.name.startswith("."):
            continue
        if entry.name == CONFIG_NAME:
            configurations.append(entry.path)
            continue
        try:
            is_folder = entry.is_dir()
        except OSError as error:  # a link to itself
            diagnostics.append(UNREADABLE.at(Source(entry.path), found=error.strerror or error))
            continue
        if is_folder:
            through = (*above, (identity, folder))
            yield from _walk(entry.path, without, diagnostics, configurations, parents, through)
        elif entry.name.lower().endswith(SUFFIXES):
            yield entry.path


def read_input(path: str) -> bytes | Diagnostic:
    """The content of an input, or why it cannot be had."""
    return content(os.path.join(os.curdir, path) if path == STANDARD_INPUT else path)
