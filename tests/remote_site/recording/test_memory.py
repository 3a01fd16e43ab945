"""The site's memory is its owner's alone, and a recorder knows whether its site lives."""

import gc
import os
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from common.errors import ProcessError
from common.messages.requests import ViewCalibration
from remote_site.link_config import RemoteLinksConfig
from remote_site.recording.camera_frames import camera_frame
from remote_site.recording.memory import AWAITED_NS, GONE_NS, RecordingMemory, memory_path, stop_waiting, wait_for_site
from remote_site.shared_ring import RingReader

NOW_NS = 10**12


def test_it_is_its_owners_alone_and_takes_no_room_until_it_is_used(tmp_path: Path) -> None:
    memory = RecordingMemory.create(tmp_path / "memory", NOW_NS)
    facts = (tmp_path / "memory").stat()
    assert stat.S_IMODE(facts.st_mode) == 0o600
    assert facts.st_blocks * 512 < 100_000
    memory.close()


SMALL_TMPFS = "mount -t tmpfs -o size={size} tmpfs {folder} && exec {python} -c '{program}' {folder}"
CREATES = "RecordingMemory.create(path, 10**12)"
WAITS_AND_CREATES = "wait_for_site(path); RecordingMemory.create(path, 10**12)"
ATTACHES = "memory = RecordingMemory.create(path, 10**12); RecordingMemory.attach(path)"
PROGRAM = """
import sys; from pathlib import Path
from common.errors import ProcessError
from remote_site.recording.memory import RecordingMemory, wait_for_site
path = Path(sys.argv[1]) / "memory"
try: {act}
except ProcessError as error: print(error)
else: print("made")
"""


def on_a_tmpfs(tmp_path: Path, size: str, act: str) -> str:
    """What becomes of the memory in a file system of this size; a write beyond it would kill the process by SIGBUS."""
    command = SMALL_TMPFS.format(size=size, folder=tmp_path, python=sys.executable, program=PROGRAM.format(act=act))
    done = subprocess.run(["unshare", "--mount", "sh", "-c", command], check=False, capture_output=True, text=True)
    if "Operation not permitted" in done.stderr:
        pytest.skip("no right to mount a small file system")
    assert done.returncode == 0, done
    return done.stdout


def test_memory_without_room_is_an_error_before_anything_is_written_to_it(tmp_path: Path) -> None:
    assert on_a_tmpfs(tmp_path, "200m", ATTACHES) == "made\n"
    assert on_a_tmpfs(tmp_path, "64k", CREATES) == "made\n"
    for act in (WAITS_AND_CREATES, ATTACHES):
        said = on_a_tmpfs(tmp_path, "64k", act)
        assert "No space left on device" in said
        assert f"free 80 MB in {tmp_path}" in said


def test_a_recorder_is_there_while_it_beats(tmp_path: Path) -> None:
    memory = RecordingMemory.create(tmp_path / "memory", NOW_NS)
    attached = RecordingMemory.attach(tmp_path / "memory")
    assert attached is not None
    now_ns = NOW_NS
    assert not memory.has_recorder(now_ns)
    attached.beat(now_ns)
    assert memory.has_recorder(now_ns + GONE_NS - 1)
    assert not memory.has_recorder(now_ns + GONE_NS)


def test_a_recorder_that_waited_gets_what_came_before_it_was_scheduled(tmp_path: Path) -> None:
    path = tmp_path / "memory"
    handle = wait_for_site(path)
    assert handle is not None
    memory = RecordingMemory.create(path, NOW_NS)
    assert memory.has_recorder(NOW_NS + AWAITED_NS - 1)
    memory.ticks.write(b"first")
    attached = RecordingMemory.attach(path)
    assert attached is not None
    assert RingReader(attached.ticks, from_first=attached.take_over()).take() == b"first"
    assert not attached.take_over()
    attached.beat(NOW_NS + GONE_NS)
    assert not memory.has_recorder(NOW_NS + 2 * GONE_NS)
    stop_waiting(path, handle)
    assert not RecordingMemory.create(path, NOW_NS).has_recorder(NOW_NS)


def test_a_site_that_has_ended_is_noticed_whether_or_not_it_cleaned_up(tmp_path: Path) -> None:
    path = tmp_path / "memory"
    memory = RecordingMemory.create(path, NOW_NS)
    attached = RecordingMemory.attach(path)
    assert attached is not None
    assert not attached.is_left()
    memory.close()
    del memory  # as after a kill: the file is still there
    gc.collect()
    assert attached.is_left()
    attached.close()
    assert RecordingMemory.attach(path) is None
    again = RecordingMemory.create(path, NOW_NS)
    found = RecordingMemory.attach(path)
    assert found is not None
    again.remove()
    assert found.is_left()
    assert not path.exists()


def test_there_is_one_recorder(tmp_path: Path) -> None:
    site = RecordingMemory.create(tmp_path / "memory", NOW_NS)
    first = RecordingMemory.attach(tmp_path / "memory")
    assert first is not None
    child = os.fork()
    if child == 0:
        try:
            RecordingMemory.attach(tmp_path / "memory")
        except ProcessError:
            os._exit(7)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    site.close()


def test_nobody_attaches_to_what_others_may_write(tmp_path: Path) -> None:
    path = tmp_path / "memory"
    memory = RecordingMemory.create(path, NOW_NS)
    path.chmod(0o666)
    with pytest.raises(ProcessError, match="remove it"):
        RecordingMemory.attach(path)
    memory.close()


def test_no_link_is_followed(tmp_path: Path) -> None:
    RecordingMemory.create(tmp_path / "memory", NOW_NS).close()
    (tmp_path / "link").symlink_to(tmp_path / "memory")
    with pytest.raises(ProcessError):
        RecordingMemory.attach(tmp_path / "link")


def test_sites_of_one_name_at_other_endpoints_have_other_memories() -> None:
    one, other = RemoteLinksConfig(), RemoteLinksConfig(control="tcp/127.0.0.1:7449")
    assert memory_path("cell", one) != memory_path("cell", other)


@pytest.mark.parametrize("scale", [1.0, -3.0])
def test_a_cameras_matrix_and_place_make_its_projection_again(scale: float) -> None:
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    matrix = np.array([[800.0, 0.5, 320], [0, 780, 240], [0, 0, 1]])
    at = np.array([0.4, -1.2, 2.0])
    projection = scale * matrix @ np.column_stack([turn, -turn @ at])
    found = camera_frame(ViewCalibration(tuple(projection.ravel().tolist()), on_tool=False))
    assert np.allclose(found.pixels_T_camera, matrix)
    assert np.allclose(found.parent_T_camera[:3, 3], at)
    assert np.allclose(found.parent_T_camera[:3, :3], turn.T)
