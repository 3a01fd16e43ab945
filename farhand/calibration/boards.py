"""Calibration from pictures of a printed board, taken before or taken now."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common.cameras.camera import Camera, Image
from common.cameras.sources import open_camera
from common.errors import CalibrationError, ConfigError, InterruptionError
from common.geometry import Array
from farhand.calibration.pictures import read_pictures
from farhand.calibration.points import Calibrated, now, with_serials
from local_site.calibration.board_rig import BoardPictures, solve_boards
from local_site.calibration.boards import Board, BoardFinder, BoardKind, BoardView, PoseGate
from local_site.calibration.coverage import coverage_map, coverage_warnings, draw_found, picture_coverage
from local_site.calibration.rig_file import save_rig
from local_site.preview.picture_files import write_picture

Pictures = tuple[Image, ...]


@dataclass(frozen=True, slots=True)
class BoardJob:
    """The board, whether its first pose stands, the cameras' sources by name, and where results go."""

    board: Board
    standing: bool
    sources: Mapping[str, str]
    out: Path
    pictures: Path | None = None


def make_board(kind: str, squares: tuple[int, int], square_mm: float, marker_mm: float, dictionary: str) -> Board:
    """The board of these words and millimetres; ConfigError names what is wrong."""
    if kind not in ("charuco", "chessboard"):
        raise ConfigError(f"--board must be charuco or chessboard (or plate, for pictures), not {kind!r}")
    known: BoardKind = "charuco" if kind == "charuco" else "chessboard"
    return Board(known, *squares, square_mm / 1000, marker_mm / 1000, dictionary)


class _Album:
    """The poses that were kept: what each camera saw of them, and the last picture of each camera."""

    def __init__(self, job: BoardJob) -> None:
        self._job = job
        self._names = tuple(job.sources)
        self._views: list[list[BoardView | None]] = [[] for _ in self._names]
        self._last: Pictures = ()

    def keep(self, pictures: Pictures, pose: Sequence[BoardView | None]) -> str:
        """Keep a pose, write what was found in it, and tell in a line what it adds."""
        self._last = pictures
        told = []
        for name, picture, view, own in zip(self._names, pictures, pose, self._views, strict=True):
            own.append(view)
            told.append(f"{name} {0 if view is None else len(view.ids)} corners, {self._covered(own, picture):.0f} %")
            if self._job.pictures is not None and view is not None:
                found = draw_found(picture, view.pixels, [str(i) for i in view.ids])
                write_picture(self._job.pictures, f"{name}_{len(own)}", found)
                write_picture(
                    self._job.pictures, f"{name}_coverage", coverage_map(_pixels(own), _size(picture), picture)
                )
        return f"pose {len(self._views[0])}: {'; '.join(told)} of the picture covered"

    def solve(self, serials: Sequence[str]) -> Calibrated:
        """The rig of the poses kept, written to its file."""
        sizes = tuple(_size(picture) for picture in self._last)
        board_pictures = BoardPictures(self._views, sizes, self._names)
        rig, control = solve_boards(board_pictures, self._job.board, now(), self._job.standing)
        rig = with_serials(rig, serials)
        save_rig(rig, self._job.out)
        return Calibrated(rig, self._job.out, coverage_warnings(control))

    def _covered(self, views: Sequence[BoardView | None], picture: Image) -> float:
        return 100 * picture_coverage(_pixels(views), _size(picture))


def calibrate_board_pictures(job: BoardJob, serials: Sequence[str] = ()) -> Calibrated:
    """The rig from pictures of a board, the n-th of each camera taken at one instant."""
    pictures = {name: read_pictures(source, name) for name, source in job.sources.items()}
    counts = {name: len(own) for name, own in pictures.items()}
    if len(set(counts.values())) > 1:
        told = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise CalibrationError(f"the cameras have different numbers of pictures ({told}); give one each per instant")
    finder, album = BoardFinder(job.board), _Album(job)
    seen = dict.fromkeys(pictures, 0)
    for instant in zip(*pictures.values(), strict=True):
        _refuse_new_size(instant, [own[0] for own in pictures.values()], list(pictures))
        pose = [finder.find(picture) for picture in instant]
        seen = {name: count + (view is not None) for (name, count), view in zip(seen.items(), pose, strict=True)}
        album.keep(instant, pose)
    _refuse_unseen(finder, {name: pictures[name] for name, count in seen.items() if count == 0})
    return album.solve(serials)


def calibrate_live(
    job: BoardJob,
    poses: int,
    should_stop: Callable[[], bool],
    say: Callable[[str], None],
    serials: Sequence[str] = (),
) -> Calibrated:
    """The rig from running cameras: keeps each new pose of the board that is held still, until there are enough."""
    finder, album, gate = BoardFinder(job.board), _Album(job), PoseGate()
    with ExitStack() as stack:
        cameras: list[Camera] = []
        for name, source in job.sources.items():
            cameras.append(open_camera(source, name))
            stack.callback(cameras[-1].close)
        for pictures in _instants(cameras, should_stop):
            pose = [finder.find(picture) for picture in pictures]
            if gate.offer(pose):
                say(f"{album.keep(pictures, pose)}; {poses - len(gate.taken)} to go, move the board")
            if len(gate.taken) >= poses:
                break
    if not gate.taken:
        if should_stop():
            raise InterruptionError("interrupted before a pose of the board was taken")
        raise CalibrationError(
            "no board was seen still by two cameras; hold it still for a moment where both see it, and check --squares "
            "and --dictionary against the print"
        )
    return album.solve(serials)


def _instants(cameras: Sequence[Camera], should_stop: Callable[[], bool]) -> Iterator[Pictures]:
    while not should_stop():
        frames = [camera.read() for camera in cameras]
        if any(frame is None for frame in frames):
            return
        yield tuple(frame.image for frame in frames if frame is not None)


def _refuse_new_size(instant: Pictures, first: Sequence[Image], names: Sequence[str]) -> None:
    for picture, expected, name in zip(instant, first, names, strict=True):
        if picture.shape[:2] != expected.shape[:2]:
            raise CalibrationError(f"camera {name}: its pictures differ in size; take all with the same settings")


def _refuse_unseen(finder: BoardFinder, pictures: Mapping[str, Sequence[Image]]) -> None:
    """CalibrationError for cameras whose pictures never show the board."""
    for name, own in pictures.items():
        if any(finder.finds_mirrored(picture) for picture in own):
            raise CalibrationError(f"camera {name}: its pictures are mirrored; switch off the camera's mirroring")
        raise CalibrationError(
            f"camera {name}: none of its {len(own)} pictures shows the board; check --board, --squares "
            "(squares, not corners) and --dictionary against the print, and light it evenly"
        )


def _pixels(views: Sequence[BoardView | None]) -> Array:
    return np.concatenate([np.zeros((0, 2)), *(view.pixels for view in views if view is not None)])


def _size(picture: Image) -> tuple[int, int]:
    return picture.shape[1], picture.shape[0]
