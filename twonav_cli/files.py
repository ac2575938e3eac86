"""Files are written whole or not at all, and known by their digest."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from twonav_cli.errors import TwonavError


def write_whole(path: Path, content: bytes | str) -> Path:
    """Write a file under a temporary name beside it and rename it.

    Raises:
        TwonavError: The folder cannot be made or written.
    """
    data = content.encode() if isinstance(content, str) else content
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            Path(temporary).chmod(0o644)
            Path(temporary).replace(path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise TwonavError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def writable(folder: Path) -> Path:
    """Return a folder that exists and can be written, before minutes are spent on what goes there.

    Raises:
        TwonavError: It cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TwonavError(f"cannot write into {folder} ({error.strerror or error}): name another --out") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise TwonavError(f"cannot write into {folder}: name another --out")
    return folder


def digest_of(contents: Iterable[bytes]) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256 of several byte strings in order."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "little"))
        digest.update(content)
    return digest.hexdigest()[:16]


def digest_of_files(paths: Iterable[Path]) -> str:
    """Return the digest of several files' contents in order."""
    return digest_of(path.read_bytes() for path in paths)
