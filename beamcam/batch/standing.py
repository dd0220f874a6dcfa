"""Files that stand where outputs of a batch go: which of them may be written over.

nothing there                         written
as the record says that it was made   written over
beamcam's, of which no record knows   written over: by `post`, or by a run that was killed
anybody else's, edited, or read-only  refused, unless the run is forced
by a link out of the folder           refused
"""

import os
import stat
from contextlib import suppress
from hashlib import sha256

from beamcam.batch import rules
from beamcam.batch.record import Record
from beamcam.errors import Diagnostic, Source
from beamcam.report.hand_list import LIST_BEGIN
from beamcam.verify.head import MOST_BEFORE, head_of


class Standing:
    """What stands in the folder of a batch."""

    def __init__(self, folder: str, record: Record, force: bool) -> None:
        self._folder, self._record, self._force = folder, record, force
        self._within: dict[str, bool] = {}  #: whether folders below are in it, links followed

    def refusal(self, output: str, content: bytes, path: str) -> Diagnostic | None:
        """Why `output` of the input at `path` cannot be written; None if it can."""
        place = os.path.join(self._folder, output)
        if not self.is_within(output):
            found = os.path.realpath(place)
            return rules.LINK.at(Source(path), found=output, to=found)
        if self._force:
            return None
        try:
            found_there = os.stat(place)
        except OSError:
            return None  # nothing is there, or writing says what is wrong
        why = _locked(found_there) or self._strange(output, place, content)
        return rules.NOT_OURS.at(Source(path), found=output, why=why) if why else None

    def is_within(self, output: str) -> bool:
        """Whether an output lies in the folder, with every link followed."""
        below = output.rpartition("/")[0]
        if below not in self._within:
            self._within[below] = is_within(self._folder, below)
        is_link = os.path.islink(os.path.join(self._folder, output))
        return self._within[below] and (not is_link or is_within(self._folder, output))

    def _strange(self, output: str, place: str, content: bytes) -> str:
        """Why a file is not what a batch made there; "" if it is."""
        if not os.path.isfile(place):
            return "which is no plain file"
        there = b""
        with suppress(OSError), open(place, "rb") as file:
            there = file.read()
        if there == content:
            return ""
        made = self._record.made.get(output)
        if made is not None:
            is_it = sha256(there).hexdigest() == made
            return "" if is_it else "which was changed since it was made"
        if there.startswith(LIST_BEGIN) or head_of(there[:MOST_BEFORE].decode("latin-1")):
            return ""
        return "which beamcam did not make"


def is_within(folder: str, output: str) -> bool:
    """Whether an output lies in a folder, with every link followed."""
    real, own = os.path.realpath(os.path.join(folder, output)), os.path.realpath(folder)
    return real == own or real.startswith(os.path.join(own, ""))


def _locked(found: os.stat_result) -> str:
    """Why a file is not to be written, by its rights; the owner of the system has none."""
    is_locked = stat.S_ISREG(found.st_mode) and not found.st_mode & 0o222
    return "which is read-only" if is_locked else ""
