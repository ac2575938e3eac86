"""Files are written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.files import digest_of, digest_of_files, write_whole


def test_text_and_bytes_are_written_into_folders_that_are_made(tmp_path: Path) -> None:
    path = write_whole(tmp_path / "a" / "b.txt", "é\n")
    assert path.read_bytes() == "é\n".encode()
    assert write_whole(path, b"\x00\x01").read_bytes() == b"\x00\x01"


def test_nothing_but_the_file_is_left_behind(tmp_path: Path) -> None:
    write_whole(tmp_path / "a", "one")
    write_whole(tmp_path / "a", "two")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_others_may_read_what_was_written(tmp_path: Path) -> None:
    assert write_whole(tmp_path / "a", "one").stat().st_mode & 0o777 == 0o644


def test_a_write_that_breaks_off_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_whole(tmp_path / "a", "old")

    def break_off(handle: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", break_off)
    with pytest.raises(KeyboardInterrupt):
        write_whole(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_one_line_and_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_whole(tmp_path / "a", "old")

    def refuse(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(TwonavError, match=r"cannot write .*a: No space left"):
        write_whole(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(TwonavError, match="cannot write"):
        write_whole(tmp_path / "file" / "a", "one")


def test_a_digest_tells_where_one_content_ends_and_the_next_begins() -> None:
    digests = {digest_of([b"ab", b"c"]), digest_of([b"a", b"bc"]), digest_of([b"abc"]), digest_of([b"c", b"ab"])}
    assert len(digests) == 4
    assert all(len(digest) == 16 for digest in digests)


def test_the_digest_of_files_is_that_of_their_contents(tmp_path: Path) -> None:
    paths = [write_whole(tmp_path / name, name) for name in ("x", "y")]
    assert digest_of_files(paths) == digest_of([b"x", b"y"])
