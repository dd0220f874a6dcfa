"""Where the outputs of a batch go: no two under one name, none over what is not a batch's own."""

import os
from collections.abc import Iterable, Mapping, Sequence

from beamcam.batch import OVER_INPUT, SAME_NAME, WRITE
from beamcam.batch.names import folded
from beamcam.batch.record import OutputState, Record
from beamcam.errors import Diagnostic, Source
from beamcam.files import FilesRead, remove_made, write_new, write_whole
from beamcam.files import write_together as write_files
from beamcam.planning.manual_list import LIST_BEGIN, LIST_SUFFIX, as_csv
from beamcam.reports.run import PartRow, Status
from beamcam.system import can_sync_all


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
        self._standing = OutputState(folder, record, force)
        self._folders = {"": folder}  #: that stand, by their names below the first

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
        other = self._read_files.written_over_by(os.path.join(self._folder, output))
        if other is not None:
            return OVER_INPUT.at(Source(path), found=output, read=other)
        return self._standing.refusal(output, content, path)

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
