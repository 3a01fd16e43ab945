"""Atomic writes: an earlier file survives a failure, and a secret is never readable by others."""

import os
from pathlib import Path

import pytest

from common.atomic_file import write_atomically


def test_a_failure_keeps_the_earlier_file_and_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "rig.json"
    write_atomically(path, b"old")

    def full(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="no space"):
        write_atomically(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mode", [0o600, 0o644])
def test_a_file_has_its_mode_before_it_has_content(tmp_path: Path, mode: int, monkeypatch: pytest.MonkeyPatch) -> None:
    modes: list[int] = []
    fdopen = os.fdopen
    monkeypatch.setattr(os, "fdopen", lambda fd, how: (modes.append(os.fstat(fd).st_mode & 0o777), fdopen(fd, how))[1])
    previous = os.umask(0o027)
    try:
        write_atomically(tmp_path / "key", b"secret", mode)
    finally:
        os.umask(previous)
    assert modes == [mode & ~0o027]
    assert (tmp_path / "key").stat().st_mode & 0o777 == mode
