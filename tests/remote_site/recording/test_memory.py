"""The site's memory is its owner's alone, and a recorder knows whether its site lives."""

import gc
import os
import stat
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from common.errors import ProcessError
from common.messages.requests import ViewCalibration
from remote_site.link_config import RemoteLinksConfig
from remote_site.recording.memory import AWAITED_NS, GONE_NS, RecordingMemory, stop_waiting, wait_for_site
from remote_site.recording.memory_files import make_file, memory_place
from remote_site.recording.transcript import camera_frame
from remote_site.shared_ring import RingReader

NOW_NS = 10**12


def test_it_is_its_owners_alone_and_takes_no_room_until_it_is_used(tmp_path: Path) -> None:
    memory = RecordingMemory.create(tmp_path / "memory", NOW_NS)
    facts = memory.path.stat()
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
    waits = wait_for_site(path)
    assert waits is not None
    assert wait_for_site(path) is None
    memory = RecordingMemory.create(path, NOW_NS)
    assert memory.has_recorder(NOW_NS + AWAITED_NS - 1)
    memory.ticks.write(b"first")
    attached = RecordingMemory.attach(path)
    assert attached is not None
    assert RingReader(attached.ticks, from_first=attached.take_over()).take() == b"first"
    assert not attached.take_over()
    attached.beat(NOW_NS + GONE_NS)
    assert not memory.has_recorder(NOW_NS + 2 * GONE_NS)
    stop_waiting(waits)
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
    assert list(tmp_path.iterdir()) == []


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
    memory.path.chmod(0o666)
    with pytest.raises(ProcessError, match="remove it"):
        RecordingMemory.attach(path)
    memory.close()


def test_no_link_is_followed(tmp_path: Path) -> None:
    memory = RecordingMemory.create(tmp_path / "memory", NOW_NS)
    memory.path.with_name(memory.path.name.replace("memory", "link")).symlink_to(memory.path)
    assert RecordingMemory.attach(tmp_path / "link") is None
    memory.close()


@pytest.fixture
def shared() -> Iterator[Path]:
    """A folder as /dev/shm is: everybody may write to it, and remove what is their own."""
    with TemporaryDirectory() as folder:
        Path(folder).chmod(0o1777)
        yield Path(folder)


def as_user(number: int, act: Callable[[], None]) -> int:
    """The exit code of a process of this user's that acts."""
    if os.geteuid() != 0:
        pytest.skip("only root may act as two users")
    child = os.fork()
    if child == 0:
        try:
            os.setgid(number)
            os.setuid(number)
            act()
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


SITES_USER, OTHER_USER = 4242, 4343


def test_files_that_another_user_made_beforehand_keep_no_site_from_being_recorded(shared: Path) -> None:
    place = shared / "memory"

    def make() -> None:
        for name in ("memory", "memory.waiting", "memory-0000000000000000", "memory-0000000000000000.waiting"):
            (shared / name).touch(0o600)
        RecordingMemory.create(place, NOW_NS)

    def record() -> None:
        waits = wait_for_site(place)
        assert waits is not None
        RecordingMemory.create(place, NOW_NS).ticks.write(b"first")
        attached = RecordingMemory.attach(place)
        assert attached is not None
        assert RingReader(attached.ticks, from_first=attached.take_over()).take() == b"first"

    assert as_user(OTHER_USER, make) == 0
    assert as_user(SITES_USER, record) == 0


def test_a_recorder_takes_no_other_users_memory_for_the_sites(shared: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    memory = RecordingMemory.create(shared / "memory", NOW_NS)
    monkeypatch.setattr("remote_site.recording.memory_files.os.geteuid", lambda: 4343)
    with pytest.raises(ProcessError, match=f"is of user {os.getuid()}: run the recorder as the user"):
        RecordingMemory.attach(shared / "memory")
    memory.close()


def test_root_records_a_users_site_but_guesses_none_of_two(shared: Path) -> None:
    place = shared / "memory"
    site = RecordingMemory.create(place, NOW_NS)
    if os.geteuid() != 0:
        pytest.skip("only root may act as two users")
    os.chown(site.path, SITES_USER, SITES_USER)
    attached = RecordingMemory.attach(place)
    assert attached is not None
    attached.close()
    second, handle = make_file(place)
    os.chown(second, OTHER_USER, OTHER_USER)
    with pytest.raises(ProcessError, match="is of user 4242 and 4343"):
        RecordingMemory.attach(place)
    own = RecordingMemory.create(place, NOW_NS)
    attached = RecordingMemory.attach(place)
    assert attached is not None
    assert attached.path == own.path
    os.close(handle)


def test_what_a_killed_recorder_and_a_killed_site_left_goes(tmp_path: Path) -> None:
    place = tmp_path / "memory"
    for kind in ("", ".waiting"):
        os.close(make_file(place, kind)[1])
    waits = wait_for_site(place)
    assert waits is not None
    site = RecordingMemory.create(place, NOW_NS)
    assert set(tmp_path.iterdir()) == {waits[0], site.path}


def test_sites_of_one_name_at_other_endpoints_have_other_memories() -> None:
    one, other = RemoteLinksConfig(), RemoteLinksConfig(control="tcp/127.0.0.1:7449")
    assert memory_place("cell", one) != memory_place("cell", other)


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
