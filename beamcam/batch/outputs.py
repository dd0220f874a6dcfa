"""Where the outputs of a batch go: no two under one name, none over what is not a batch's own.

nothing there                         written
as the record says that it was made   written over
beamcam's, of which no record knows   written over: by `post`, or by a run that was killed
anybody else's, edited, or read-only  refused, unless the run is forced
by a link out of the folder           refused
"""

import os
import stat
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from hashlib import sha256

from beamcam.batch import LINK, NOT_OURS, OVER_INPUT, SAME_NAME, WRITE
from beamcam.batch.names import folded
from beamcam.batch.record import Record, is_within
from beamcam.checks.job import MOST_BEFORE, head_of
from beamcam.errors import Diagnostic, Source
from beamcam.files import FilesRead, remove_made, write_new, write_whole
from beamcam.files import write_together as write_files
from beamcam.planning.manual_list import LIST_BEGIN, LIST_SUFFIX, as_csv
from beamcam.readers.dstv import MADE
from beamcam.reports.run import PartRow, Status
from beamcam.system import can_sync_all

#: In the form that a part has which another machine has begun: of DSTV, and of JSON.
REST_MARKS = (MADE.encode(), b'"made": {')


class Outputs:
    """The folder that a run writes to."""

    def __init__(
        self, folder: str, record: Record, claims: dict[str, str], read: FilesRead,
        force: bool = False, dry: bool = False,
    ) -> None:  # fmt: skip
        """`claims` says which input has which name, and is added to. None of `read` is replaced.

        A `dry` run writes nothing; what is not as a batch made it is written over by `force` only.
        """
        self._folder, self._claims, self._read_files, self._dry = folder, claims, read, dry
        self._record, self._force = record, force
        self._folders = {"": folder}  #: that stand, by their names below the first
        self._within: dict[str, bool] = {}  #: whether folders below are in it, links followed

    def write_together(
        self, parts: Sequence[PartRow], files: dict[str, bytes], path: str
    ) -> tuple[Diagnostic | None, Status]:
        """Write the programs of a part, their lists of manual work and rests: all, or none.

        An older list is removed.
        """
        if (clash := self.claim(files, path)) is not None:
            return clash, "refused"
        for part in parts:
            if part["by_hand"]:
                listed = as_csv(part["by_hand"]).encode("utf-8")
                files = {part["output"] + LIST_SUFFIX: listed, **files}
        for output, content in files.items():
            if (refusal := self.refusal(output, content, path)) is not None:
                return refusal, "refused"
        for part in parts:
            if not part["by_hand"] and not self._dry:
                remove_made(os.path.join(self._folder, part["output"] + LIST_SUFFIX), LIST_BEGIN)
        return self.write(files, path), "failed"

    def claim(self, outputs: Iterable[str], path: str) -> Diagnostic | None:
        """Take the names for outputs of an input, or say why it cannot have one of them."""
        by_key = {folded(output): output for output in outputs}
        for name, output in by_key.items():
            other = self._claims.get(name, path)
            if other != path:
                return SAME_NAME.at(Source(path), found=output, other=other)
        self._claims |= dict.fromkeys(by_key, path)
        return None

    def refusal(self, output: str, content: bytes, path: str) -> Diagnostic | None:
        """Why an output may not be written: an input of the run is there, or what is not ours."""
        place = os.path.join(self._folder, output)
        other = self._read_files.written_over_by(place)
        if other is not None:
            return OVER_INPUT.at(Source(path), found=output, read=other)
        below = output.rpartition("/")[0]
        if below not in self._within:
            self._within[below] = is_within(self._folder, below)
        if not self._within[below] or (
            os.path.islink(place) and not is_within(self._folder, output)
        ):
            return LINK.at(Source(path), found=output, to=os.path.realpath(place))
        why = "" if self._force else self._strange(output, place, content)
        return NOT_OURS.at(Source(path), found=output, why=why) if why else None

    def _strange(self, output: str, place: str, content: bytes) -> str:
        """Why a file is not to be written over; "" if it is what a batch made, or none is there."""
        try:
            mode = os.stat(place).st_mode
        except OSError:
            return ""  # nothing is there, or writing says what is wrong
        if not stat.S_ISREG(mode):
            return "which is no plain file"
        if not mode & 0o222:  # by its rights, of which the owner of the system has none
            return "which is read-only"
        there = b""
        with suppress(OSError), open(place, "rb") as file:
            there = file.read()
        if there == content:
            return ""
        made = self._record.made.get(output)
        if made is not None:
            is_it = sha256(there).hexdigest() == made
            return "" if is_it else "which was changed since it was made"
        is_ours = there.startswith(LIST_BEGIN) or any(mark in there for mark in REST_MARKS)
        if is_ours or head_of(there[:MOST_BEFORE].decode("latin-1")):
            return ""
        return "which beamcam did not make"

    def write(self, files: Mapping[str, bytes], path: str) -> Diagnostic | None:
        """Write files, all of them or none, and say why not."""
        if self._dry:
            return None
        output = ""
        try:
            for output in files:
                below = output.rpartition("/")[0]
                if below not in self._folders:
                    folder = os.path.join(self._folder, below)
                    os.makedirs(folder, exist_ok=True)
                    self._folders[below] = folder
            if len(files) > 1:
                places = {os.path.join(self._folder, name): of for name, of in files.items()}
                write_files(places, durable=not can_sync_all())
                return None
            for output, content in files.items():
                below, _, name = output.rpartition("/")
                folder = self._folders[below]
                if not write_new(folder, name, content):
                    write_whole(os.path.join(folder, name), content, durable=not can_sync_all())
        except OSError as error:
            return WRITE.at(Source(path), found=output, reason=error.strerror or error)
        return None
