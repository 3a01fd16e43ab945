"""A disk that is full while a video is written: an error as of any file, and no crash of the library below."""

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import errno, resource, signal, sys
import numpy as np
from pathlib import Path
from farhand.export.videos.h264 import H264File

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
random = np.random.default_rng(1)
file = H264File(Path(sys.argv[1]), (64, 48), 30, 10, 20)
try:
    try:
        for _ in range(200):
            file.add(random.integers(0, 255, (48, 64, 3), dtype=np.uint8))
    finally:
        file.finish()
except OSError as error:
    print(errno.errorcode[error.errno])
"""
NO_LIMIT = -1


@pytest.mark.parametrize(
    ("target", "most_bytes", "expected"), [("/dev/full", NO_LIMIT, "ENOSPC"), (None, 60_000, "EFBIG")]
)
def test_it_is_an_error_and_the_process_lives(
    target: str | None, most_bytes: int, expected: str, tmp_path: Path
) -> None:
    """At once, before there is a header, and in the middle of the file."""
    path = tmp_path / "video.mp4"
    if target is not None:
        path.symlink_to(target)
    command = [sys.executable, "-c", PROGRAM, str(path), str(most_bytes)]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, f"{expected}\n"), done.stderr
