"""A hot folder: which of its files are complete, and where they go when they are done.

    seen     size and time of change as before?   for long enough?   has its end?   handed over?
    M58.nc1  no: it is being written -> wait      no -> wait         no -> wait     yes -> leave it

A file that changes after it was handed over is complete again some time later.
"""

import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress

from msgspec import Struct
from msgspec.structs import replace

from beamcam.batch.find import Input
from beamcam.files import write_whole
from beamcam.readers import has_end
from beamcam.reports.run import FileRow, encoded, message_line

AGAIN_S = 30.0  #: after which what failed for the disk or a process is tried again
END_S = 60.0  #: after which a file without its end is handed over all the same


class Stamp(Struct, frozen=True):
    """File data that reveal a change."""

    size: int
    changed_ns: int
    inode: int


class Sight(Struct, frozen=True):
    """A file as it was last seen."""

    stamp: Stamp
    since_s: float  #: when it was first seen so; of one to be tried again, when from
    handed: bool = False
    endless: bool = False  #: handed over though its end is missing


def look(inputs: Iterable[Input]) -> dict[Input, Stamp]:
    """The stamp of each input that is there."""
    stamps = {}
    for found in inputs:
        with suppress(OSError):  # it was taken away since the folder was listed
            at = os.stat(found.path)
            stamps[found] = Stamp(at.st_size, at.st_mtime_ns, at.st_ino)
    return stamps


class HotFolder:
    """State of the files of a folder between two scans."""

    def __init__(
        self, settle_s: float, end_s: float = END_S, ends: Callable[[str], bool] = has_end
    ) -> None:
        """`ends` says of a path whether the file has its end, which is waited for `end_s`."""
        self._settle_s, self._end_s, self._ends = settle_s, end_s, ends
        self._seen: dict[Input, Sight] = {}
        self.endless: tuple[Input, ...] = ()

    def take(self, stamps: Mapping[Input, Stamp], now_s: float) -> tuple[Input, ...]:
        """The inputs that are complete now, each handed over once as long as it stays the same.

        Those among them whose end was waited for in vain are then `endless`.
        """
        fresh = {}
        for found, stamp in stamps.items():
            sight = self._seen.get(found)
            if sight is None or sight.stamp != stamp:
                sight = Sight(stamp, now_s)
            fresh[found] = sight
        ready = []
        self.endless = ()
        for found, sight in fresh.items():
            stood_s = now_s - sight.since_s
            if sight.handed or stood_s < self._settle_s:
                continue
            endless = not (sight.endless or self._ends(found.path))
            if endless and stood_s < self._end_s:
                continue
            if endless:
                self.endless = (*self.endless, found)
            fresh[found] = replace(sight, handed=True, endless=endless or sight.endless)
            ready.append(found)
        self._seen = fresh
        return tuple(ready)

    @property
    def is_waiting(self) -> bool:
        """Whether there is a file that has not been handed over."""
        return not all(sight.handed for sight in self._seen.values())

    def again(self, found: Input, now_s: float) -> None:
        """Hand an input over again after a while, even if it has not changed."""
        self._seen[found] = replace(self._seen[found], handed=False, since_s=now_s + AGAIN_S)

    def is_as_seen(self, found: Input) -> bool:
        """Whether an input is still what was handed over."""
        return look([found]).get(found) == self._seen[found].stamp


def file_away(found: Input, folder: str, row: FileRow | None = None) -> str:
    """Move an input into `folder`, below it as below the hot folder, and give its path there.

    An older one of the name is kept and the new one numbered. With `row` its messages are written
    beside it. Raises OSError.
    """
    place = os.path.join(folder, *found.tree.split("/"))
    os.makedirs(os.path.dirname(place), exist_ok=True)
    target = next(path for path in _numbered(place) if not os.path.lexists(path))
    if row is not None:
        text = "".join(message_line(message) + "\n" for message in row["messages"])
        write_whole(f"{target}.txt", encoded(text))
    shutil.move(found.path, target)
    return target


def _numbered(path: str) -> Iterator[str]:
    """`path`, then with -2, -3, ... before its suffix."""
    stem, suffix = os.path.splitext(path)
    yield path
    number = 2
    while True:
        yield f"{stem}-{number}{suffix}"
        number += 1
