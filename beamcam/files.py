"""Output files: whole, or not at all."""

import os
import stat
from collections.abc import Iterable
from contextlib import suppress

_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)


def write_whole(
    path: str | os.PathLike[str], data: str | bytes | Iterable[bytes], durable: bool = True
) -> None:
    """Write `data` to `path` so that no reader ever sees a part of it.

    It goes to a temporary file beside the target, reaches the disk and is renamed over it; a
    process that dies in between leaves the old file, or none. `durable=False` leaves the way to
    the disk to the system: a process that dies still leaves no part, a power cut may. An iterable
    of bytes is written piece by piece. Raises OSError.
    """
    if isinstance(data, str):
        data = data.encode("utf-8")
    target, mode = os.fspath(path), None
    with suppress(FileNotFoundError):
        mode = os.lstat(target).st_mode
    if mode is not None and stat.S_ISLNK(mode):
        # A link is written through, as a shell's redirection does.
        target, mode = os.path.realpath(target), None
        with suppress(FileNotFoundError):
            mode = os.stat(target).st_mode
    folder, name = os.path.split(target)
    # The process's number keeps two writers apart; a name left by a dead one is used again.
    part = os.path.join(folder, f".{name[:40]}.{os.getpid()}.part")
    try:
        file = os.open(part, _FLAGS, 0o666)
    except FileExistsError:
        os.unlink(part)
        file = os.open(part, _FLAGS, 0o666)
    try:
        try:
            for piece in (data,) if isinstance(data, bytes) else data:
                _write(file, piece)
            if durable:
                os.fsync(file)
        finally:
            os.close(file)
        if mode is not None:
            os.chmod(part, mode & 0o777)
        os.replace(part, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(part)
        raise


def _write(file: int, piece: bytes) -> None:
    """All of `piece`; the system may take it in parts."""
    done = os.write(file, piece)
    while done < len(piece):
        done += os.write(file, memoryview(piece)[done:])
