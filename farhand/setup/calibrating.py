"""The calibration step: pairs taken and kept on disk, the rig solved from them, what to do about a poor one."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from pathlib import Path

from msgspec.structs import replace

from common.cameras.images import write_image
from common.errors import CalibrationError, CameraError
from farhand.calibration.boards import Pictures, calibrate_board_pictures, instants
from farhand.calibration.pictures import PictureJob, read_pictures
from farhand.calibration.points import describe, solvable
from farhand.doctor.findings import Severity, as_text, worst
from farhand.setup.board_page import BOARD
from farhand.setup.conversation import SetupPerson, choose, confirm
from farhand.setup.finding_cameras import OpenCamera
from farhand.setup.guided_calibration import SHOWN_GAPS, Guide, judge_rig, take_pairs
from farhand.setup.notes import NAMES, SetupAnswers, SetupFolder
from farhand.terminal import ShowProgress
from local_site.calibration.boards import Board

BarMaker = Callable[[], AbstractContextManager[ShowProgress]]  # a bar, while it is entered

ENDED = (
    "a camera came to its end before a pair was kept: give cameras that run (a recording or a cut stream ends), and "
    "check cable and power"
)
NEXT = {"more": "take more pairs", "again": "put these pairs aside and begin anew", "solve": "solve with these pairs"}
KEEP = {"keep": "keep this calibration", **{key: NEXT[key] for key in ("more", "again")}}


def printed_board(answers: SetupAnswers) -> Board:
    """The board as it was printed, by the square that was measured."""
    square = BOARD.square if answers.square_mm is None else answers.square_mm / 1000
    return Board(BOARD.kind, BOARD.columns, BOARD.rows, square, BOARD.marker * square / BOARD.square, BOARD.dictionary)


def calibrate(
    folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, open_camera: OpenCamera, progress: BarMaker
) -> SetupAnswers:
    """Take pairs until they suffice and the person is content with the rig, which is then in the folder."""
    board = printed_board(answers)
    if answers.pairs_by not in (None, answers.pairs_need):
        person.tell("the pairs of an earlier run are of other cameras or sizes; they are now in calibration.old")
        folder.put_pairs_aside()
    pairs = kept_pairs(folder)
    chosen = "more"
    if pairs:
        chosen = choose(person, f"{len(pairs)} pairs of an earlier run are there. What now?", NEXT, "more")
    while chosen != "keep":
        if chosen == "again":
            folder.put_pairs_aside()
        if chosen == "again" or not kept_pairs(folder):
            lying = confirm(person, "Does the board lie level at first (else it stands, facing the cameras)?", True)
            answers = folder.keep(replace(answers, standing=not lying, pairs_by=answers.pairs_need))
        if chosen != "solve":
            _take(folder, answers, person, open_camera, progress)
        if kept_pairs(folder):
            chosen = _solve(folder, answers, board, person, progress)
        else:
            person.tell(ENDED)
            chosen = choose(person, "What now? Ctrl-C leaves", {"more": "take pairs once the cameras run"}, "more")
    return replace(answers, rig_by=answers.rig_needs)


def kept_pairs(folder: SetupFolder) -> list[Pictures]:
    """The pairs on disk; pictures without their pair are removed, those of a damaged file are refused."""
    numbers = [{path.name for path in folder.pictures(name).glob("*.png")} for name in NAMES]
    complete = sorted(set.intersection(*numbers))
    for name, own in zip(NAMES, numbers, strict=True):
        for alone in own - set(complete):
            (folder.pictures(name) / alone).unlink()
    if not complete:
        return []
    return list(zip(*(read_pictures(str(folder.pictures(name)), name) for name in NAMES), strict=True))


def _take(
    folder: SetupFolder, answers: SetupAnswers, person: SetupPerson, open_camera: OpenCamera, progress: BarMaker
) -> None:
    """Take pairs with the cameras as they are set; a person who interrupts has kept what was taken."""
    guide = Guide(printed_board(answers), NAMES)
    with progress() as show:
        guide.restore(kept_pairs(folder), show)
    if not guide.kept:
        how = "upright, facing the cameras" if answers.standing else "level, in the middle of where the hand will work"
        person.tell(f"put the board {how}, its edges along the room's: the first pair sets the operator's frame")
        person.ask("Press Enter when it is there and at rest", "")
    person.tell("now move the board: hold it still for a moment at each new place; Ctrl-C leaves, and keeps the pairs")
    with ExitStack() as opened:
        cameras = [
            opened.enter_context(closing(open_camera(source, name, answers.settings)))
            for name, source in answers.sources.items()
        ]
        take_pairs(guide, instants(cameras, lambda: False), lambda k, pictures: _keep(folder, k, pictures), person)
    if guide.missing and guide.kept:
        person.tell(f"a camera came to its end; still missing: {'; '.join(guide.missing[:SHOWN_GAPS])}")


def _keep(folder: SetupFolder, number: int, pictures: Pictures) -> None:
    for name, picture in zip(NAMES, pictures, strict=True):
        write_image(folder.pictures(name), f"{number:03d}", picture)


def _solve(folder: SetupFolder, answers: SetupAnswers, board: Board, person: SetupPerson, progress: BarMaker) -> str:
    """Solve the rig of the pairs on disk; what the person wants next."""
    sources = {name: str(folder.pictures(name)) for name in NAMES}
    job = PictureJob(sources, folder.rig, folder.path / "found")
    try:
        with solvable(), progress() as show:
            done = calibrate_board_pictures(job, board, answers.standing, show)
    except (CalibrationError, CameraError) as error:
        person.tell(str(error))
        return choose(person, "There is no calibration yet. What now?", _without(NEXT, "solve"), "more")
    _tell(person, describe(done).splitlines())
    findings = judge_rig(done.rig, len(list(Path(sources[NAMES[0]]).iterdir())))
    _tell(person, as_text(findings).splitlines())
    if worst(findings) is Severity.OK:
        return "keep"
    return choose(person, "The calibration is worse than usual. What now?", KEEP, "more")


def _without(options: dict[str, str], key: str) -> dict[str, str]:
    return {name: meaning for name, meaning in options.items() if name != key}


def _tell(person: SetupPerson, lines: Sequence[str]) -> None:
    for line in lines:
        person.tell(line)
