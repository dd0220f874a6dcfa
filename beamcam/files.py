"""Output files: whole, or not at all."""

import os
import tempfile
from contextlib import suppress
from pathlib import Path


def write_whole(path: Path, data: str | bytes) -> None:
    """Write `data` to `path` so that no reader ever sees a part of it.

    It goes to a temporary file beside the target, reaches the disk and is renamed over it; a
    process that dies in between leaves the old file, or none. Raises OSError.
    """
    raw = data.encode("utf-8") if isinstance(data, str) else data
    target = path.resolve()  # a link is written through, as a shell's redirection does
    handle, name = tempfile.mkstemp(
        prefix=f".{target.name[:40]}.", suffix=".part", dir=target.parent
    )
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(raw)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, _mode(target))
        os.replace(name, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise


def _mode(target: Path) -> int:
    """The mode that the file has, or that a new file would have."""
    try:
        return target.stat().st_mode & 0o777
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask
