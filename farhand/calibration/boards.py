"""Calibration from pictures of a printed board: recorded ones, or those of running cameras."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing

import numpy as np

from common.cameras.camera import Camera, Image
from common.errors import CalibrationError, ConfigError, InterruptionError
from common.geometry import Array
from farhand.calibration.cameras import open_named
from farhand.calibration.pictures import PictureJob, read_pictures, size_of, write_coverage, write_found
from farhand.calibration.points import Calibrated, now, write_rig
from farhand.terminal import ShowProgress
from local_site.calibration.board_rig import BoardPictures, solve_boards
from local_site.calibration.boards import Board, BoardFinder, BoardKind, BoardView, PoseGate
from local_site.calibration.coverage import picture_coverage

Pictures = tuple[Image, ...]

LOOKING, SOLVING = "looking for the board", "solving the cameras"


def make_board(kind: str, squares: tuple[int, int], square_mm: float, marker_mm: float, dictionary: str) -> Board:
    """The board of these words and millimetres; ConfigError names what is wrong."""
    if kind not in ("charuco", "chessboard"):
        raise ConfigError(f"--board must be charuco or chessboard (or plate, for pictures), not {kind!r}")
    known: BoardKind = "charuco" if kind == "charuco" else "chessboard"
    return Board(known, *squares, square_mm / 1000, marker_mm / 1000, dictionary)


class _Album:
    """The poses that were kept: what each camera saw of them, and the last picture of each camera."""

    def __init__(self, job: PictureJob, board: Board, standing: bool) -> None:
        self._job, self._board, self._standing = job, board, standing
        self._views: dict[str, list[BoardView | None]] = {name: [] for name in job.sources}
        self._last: Pictures = ()

    def keep(self, pictures: Pictures, pose: Sequence[BoardView | None]) -> str:
        """Keep a pose, write what was found in it, and describe in a line what it adds."""
        self._last = pictures
        described = []
        for (name, own), picture, view in zip(self._views.items(), pictures, pose, strict=True):
            own.append(view)
            covered = 100 * picture_coverage(_pixels(own), size_of(picture))
            described.append(f"{name} {0 if view is None else len(view.ids)} corners, {covered:.0f} %")
            if self._job.pictures is not None and view is not None:
                found = view.pixels, [str(i) for i in view.ids]
                write_found(self._job.pictures, name, len(own), picture, found)
                write_coverage(self._job.pictures, name, picture, _pixels(own))
        return f"pose {len(own)}: {'; '.join(described)} of the picture covered"

    def solve(self) -> Calibrated:
        """The rig of the poses kept, written to its file."""
        sizes = tuple(size_of(picture) for picture in self._last)
        board_pictures = BoardPictures(list(self._views.values()), sizes, tuple(self._views))
        rig, control = solve_boards(board_pictures, self._board, now(), self._standing)
        return write_rig(rig, control, self._job.out, self._job.serials)


def calibrate_board_pictures(job: PictureJob, board: Board, standing: bool, show: ShowProgress) -> Calibrated:
    """The rig from pictures of a board, the n-th of each camera taken at one instant.

    `standing` is whether the board is upright in its first pose; `show` is told of each picture that was searched.
    """
    pictures = {name: read_pictures(source, name) for name, source in job.sources.items()}
    if len({len(own) for own in pictures.values()}) > 1:
        counts = ", ".join(f"{name} {len(own)}" for name, own in pictures.items())
        raise CalibrationError(f"the cameras have different numbers of pictures ({counts}); give one each per instant")
    finder, album = BoardFinder(board), _Album(job, board, standing)
    unseen, total = set(pictures), sum(map(len, pictures.values()))
    show(LOOKING, 0, total)
    for k, instant in enumerate(zip(*pictures.values(), strict=True)):
        for picture, (name, own) in zip(instant, pictures.items(), strict=True):
            if picture.shape[:2] != own[0].shape[:2]:
                raise CalibrationError(f"camera {name}: its pictures differ in size; take all with the same settings")
        pose = []
        for picture in instant:
            pose.append(finder.find(picture))
            show(LOOKING, k * len(pictures) + len(pose), total)
        unseen -= {name for name, view in zip(pictures, pose, strict=True) if view is not None}
        album.keep(instant, pose)
    _refuse_unseen(finder, {name: own for name, own in pictures.items() if name in unseen})
    show(SOLVING, 0, None)
    solved = album.solve()
    show(SOLVING, 1, 1)
    return solved


def calibrate_live(
    job: PictureJob,
    board: Board,
    standing: bool,
    poses: int,
    should_stop: Callable[[], bool],
    echo: Callable[[str], None],
) -> Calibrated:
    """The rig from running cameras: keeps each new pose of the board that is held still, until there are enough."""
    finder, album, gate = BoardFinder(board), _Album(job, board, standing), PoseGate()
    with ExitStack() as stack:
        cameras = [stack.enter_context(closing(camera)) for camera in open_named(job.sources, job.setup)]
        for pictures in instants(cameras, should_stop):
            pose = [finder.find(picture) for picture in pictures]
            if gate.offer(pose):
                echo(f"{album.keep(pictures, pose)}; {poses - len(gate.taken)} to go, move the board")
            if len(gate.taken) >= poses:
                break
    if not gate.taken:
        if should_stop():
            raise InterruptionError("interrupted before a pose of the board was taken")
        raise CalibrationError(
            "no board was seen still by two cameras; hold it still for a moment where both see it, and check --squares "
            "and --dictionary against the print"
        )
    return album.solve()


def instants(cameras: Sequence[Camera], should_stop: Callable[[], bool]) -> Iterator[Pictures]:
    """The newest picture of each camera, again and again, until one ends or it is to stop."""
    while not should_stop():
        frames = [camera.read() for camera in cameras]
        if any(frame is None for frame in frames):
            return
        yield tuple(frame.image for frame in frames if frame is not None)


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
