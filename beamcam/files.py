"""Output files: whole, or not at all."""

import errno
import os
import stat
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import partial

from beamcam.system import BINARY, replace_file, taken_back

REFUSED_SUFFIX = ".refused"  #: behind the name of an output whose program was refused

_NEW = os.O_CREAT | os.O_EXCL | os.O_WRONLY | BINARY
#: A file without a name, where the system has such: a process that dies leaves nothing of it.
_UNNAMED = getattr(os, "O_TMPFILE", 0) if os.path.isdir("/proc/self/fd") else 0


def write_whole(
    path: str | os.PathLike[str], data: str | bytes | Iterable[bytes], durable: bool = True
) -> None:
    """Write `data` to `path` so that no reader ever sees a part of it.

    It goes to a file beside the target that has no name yet, or a temporary one where the system
    knows no other, reaches the disk and takes the target's name; a process that dies in between
    leaves the old file, or none. `durable=False` leaves the way to the disk to the system: a
    process that dies still leaves no part, a power cut may. An iterable of bytes is written piece
    by piece. A device or a pipe is written to, and stays what it is. Raises OSError.
    """
    if isinstance(data, str):
        data = data.encode("utf-8")
    target = os.fspath(path)
    mode = _mode(target)
    if mode is not None and not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        file = os.open(target, os.O_WRONLY | BINARY)  # /dev/null, a printer, a pipe
        try:
            _write_all(file, data)
        finally:
            os.close(file)
        return
    # A link is written through, as a shell's redirection does.
    target = os.path.realpath(target) if os.path.islink(target) else target
    part = _part(target, "")
    with taken_back(partial(os.unlink, part)):
        _write_part(target, part, mode, data, durable)


def _part(target: str, number: str) -> str:
    """A temporary name beside a file.

    The process's number keeps two writers apart; a name left by a dead one is used again.
    """
    folder, name = os.path.split(target)
    return os.path.join(folder, f".{name[:40]}.{os.getpid()}{number}.part")


def _write_part(
    target: str, part: str, mode: int | None, data: bytes | Iterable[bytes], durable: bool
) -> None:
    """Write a new file, which has the name `part` if it has any, until it is the target.

    `mode` is that of the file there, if any.
    """
    unnamed = _unnamed(os.path.dirname(target) or os.curdir)
    named = unnamed is None
    file = _new(part, 0o666) if unnamed is None else unnamed
    try:
        try:
            _write_all(file, data)
            if mode is not None:
                os.chmod(part if named else file, mode & 0o777)
            if durable:
                os.fsync(file)
            if not named:
                if mode is None and _link(file, target):
                    return
                named = True
                if not _link(file, part):  # a system that lets no name be given to it
                    os.lseek(file, 0, os.SEEK_SET)
                    copy = _new(part, os.fstat(file).st_mode & 0o777)
                    try:
                        while piece := os.read(file, 1 << 20):
                            _write(copy, piece)
                        if durable:
                            os.fsync(copy)
                    finally:
                        os.close(copy)
        finally:
            os.close(file)
        replace_file(part, target)
    except BaseException:
        if named:
            with suppress(OSError):
                os.unlink(part)
        raise


class FilesRead:
    """The files that a command reads, none of which may be written over.

    They are looked at when an output is the name of a file that stands already, not before.
    """

    def __init__(self, paths: Iterable[str]) -> None:
        self._paths = paths
        self._known: dict[object, str] | None = None

    def written_over_by(self, output: str) -> str | None:
        """That of the files which is the file `output` too; None if none is.

        Whatever it is called: by a link of either kind, by another folder, in other letters where
        the system does not tell them apart. A device stays what it is and may be both.
        """
        identity = _identity(output)
        if identity is None:
            return None
        if self._known is None:
            self._known = {_identity(path): path for path in self._paths}
        return self._known.get(identity)


def _identity(path: str) -> object:
    """Key that names of one file share; None if there is no such file."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    if not stat.S_ISREG(status.st_mode):
        return None
    return (status.st_dev, status.st_ino) if status.st_ino else os.path.realpath(path)


def write_new(folder: str, name: str, data: bytes) -> bool:
    """Write `data` as `write_whole` does with `durable=False`, if nothing stands there, and say so.

    Whether something does is found by trying, so that many new files cost little. False too where
    the system knows no other way than a temporary name. Raises OSError.
    """
    file = _unnamed(folder)
    if file is None:
        return False
    try:
        _write(file, data)
        return _link(file, f"{folder}/{name}")
    finally:
        os.close(file)


def write_together(files: Mapping[str, bytes], durable: bool = True) -> None:
    """Write plain files by their paths so that all of them stand in the end, or none is new.

    Each is whole under a temporary name before the last takes its own, and the others after it.
    Where that fails in mid way those that have theirs are removed: what goes together is never
    found in part. Raises OSError.
    """
    parts: dict[str, str] = {}  #: temporary name -> path
    named: list[str] = []

    def undo() -> None:
        for path in (*parts, *named):
            with suppress(OSError):
                os.unlink(path)

    with taken_back(undo):
        try:
            for k, (path, data) in enumerate(files.items()):
                target = os.path.realpath(path) if os.path.islink(path) else path
                mode = _mode(target)
                if mode is not None and not stat.S_ISREG(mode):
                    raise OSError(errno.EEXIST, "no plain file")
                part = _part(target, f"-{k}")
                parts[part] = target
                file = _new(part, 0o666)
                try:
                    _write(file, data)
                    if mode is not None:
                        os.chmod(part, mode & 0o777)
                    if durable:
                        os.fsync(file)
                finally:
                    os.close(file)
            for part, target in reversed(parts.items()):
                replace_file(part, target)
                named.append(target)
            named.clear()
        except BaseException:
            undo()
            raise


def remove_made(path: str, begin: bytes) -> None:
    """Take a file away that begins so; anything else that has the name stays as it is."""
    with suppress(OSError):
        with open(path, "rb") as file:
            made = file.read(len(begin)) == begin
        if made:
            os.unlink(path)


def _new(path: str, mode: int) -> int:
    """A new file, in place of one that was left there."""
    with suppress(FileNotFoundError):
        os.unlink(path)
    return os.open(path, _NEW, mode)


def _unnamed(folder: str) -> int | None:
    """A new file in `folder` without a name.

    None where the file system has no such, or the folder is wrong: the other way says so then.
    """
    try:
        return os.open(folder, _UNNAMED | os.O_RDWR, 0o666) if _UNNAMED else None
    except OSError:
        return None


def _mode(path: str) -> int | None:
    """File mode of the target of a path or a link; None if nothing is there."""
    with suppress(FileNotFoundError):
        return os.stat(path).st_mode
    return None


def _write_all(file: int, data: bytes | Iterable[bytes]) -> None:
    for piece in (data,) if isinstance(data, bytes) else data:
        _write(file, piece)


def _write(file: int, piece: bytes) -> None:
    """All of `piece`; the system may take it in parts."""
    done = os.write(file, piece)
    while done < len(piece):
        done += os.write(file, memoryview(piece)[done:])


def _link(file: int, path: str) -> bool:
    """Give an unnamed file its name, and whether that went well: the name may be taken."""
    try:
        os.link(f"/proc/self/fd/{file}", path, src_dir_fd=file, follow_symlinks=True)
    except OSError:
        return False
    return True
