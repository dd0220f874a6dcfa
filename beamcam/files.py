"""Output files: whole, or not at all."""

import os
from contextlib import suppress


def write_whole(path: str | os.PathLike[str], data: str | bytes) -> None:
    """Write `data` to `path` so that no reader ever sees a part of it.

    It goes to a temporary file beside the target, reaches the disk and is renamed over it; a
    process that dies in between leaves the old file, or none. Raises OSError.
    """
    raw = data.encode("utf-8") if isinstance(data, str) else data
    target = os.path.realpath(path)  # a link is written through, as a shell's redirection does
    folder, name = os.path.split(target)
    # The process's number keeps two writers apart; a name left by a dead one is used again.
    part = os.path.join(folder, f".{name[:40]}.{os.getpid()}.part")
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
    with suppress(FileNotFoundError):
        os.unlink(part)
    try:
        with open(os.open(part, flags | os.O_EXCL, 0o666), "wb") as file:
            file.write(raw)
            file.flush()
            os.fsync(file.fileno())
        with suppress(FileNotFoundError):
            os.chmod(part, os.stat(target).st_mode & 0o777)
        os.replace(part, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(part)
        raise
