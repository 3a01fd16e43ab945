"""Calibration with guidance: takes the pairs that are worth keeping, and says what is still missing."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Image
from farhand.calibration.boards import Pictures
from farhand.calibration.pictures import size_of
from farhand.doctor.findings import Finding, ok, warning
from farhand.setup.conversation import SetupPerson
from farhand.terminal import ShowProgress
from local_site.calibration.boards import Board, BoardFinder, BoardView, PoseGate, edge_blur_px
from local_site.calibration.pose_gaps import pose_gaps
from local_site.calibration.rig import Rig
from local_site.kernels.pictures import as_grey

MAX_BLUR_PX = 1.5
USUAL_RMS_PX = 0.3
FEW_POSES_RATIO = 2.0
SHOWN_GAPS = 3
READING = "looking at the pictures of the last run"


@dataclass(frozen=True, slots=True)
class Judged:
    """The verdict on a pair: whether it is kept, and a line about what is seen."""

    kept: bool
    line: str


class Guide:
    """Judges pairs of pictures of a board, and knows what those that were kept lack."""

    def __init__(self, board: Board, names: Sequence[str]) -> None:
        self._board, self._names = board, tuple(names)
        self._finder, self._gate = BoardFinder(board), PoseGate()
        self._sizes: list[tuple[int, int]] = []
        self.missing: list[str] = pose_gaps([], board, names, [(4, 3)] * len(names))

    @property
    def kept(self) -> int:
        """The number of pairs that were kept."""
        return len(self._gate.taken)

    def restore(self, pairs: Sequence[Pictures], show: ShowProgress) -> None:
        """Take the pairs that an earlier run kept, if there are any; the first of them stays the first."""
        for k, pictures in enumerate(pairs):
            show(READING, k, len(pairs))
            self._gate.taken.append(self._look(pictures))
            self._update()
            show(READING, k + 1, len(pairs))

    def judge(self, pictures: Pictures) -> Judged:
        """Keep a pair whose board is sharp, still and at a new place; else say why it is not kept."""
        pose = self._look(pictures)
        blurred = self._blurred(pictures, pose)
        if blurred:
            return Judged(False, f"the board is blurred in the {blurred} view: hold it still, and check the focus")
        if self._gate.offer(pose):
            self._update()
            return Judged(True, f"pair {self.kept} kept")
        return Judged(False, self._describe(pose))

    def _look(self, pictures: Pictures) -> list[BoardView | None]:
        self._sizes = [size_of(picture) for picture in pictures]
        return [self._finder.find(picture) for picture in pictures]

    def _update(self) -> None:
        self.missing = pose_gaps(self._gate.taken, self._board, self._names, self._sizes)

    def _blurred(self, pictures: Sequence[Image], pose: Sequence[BoardView | None]) -> str:
        """The names of the views that show the board blurred."""
        seen = zip(self._names, pictures, pose, strict=True)
        blurs = {name: edge_blur_px(as_grey(picture), view.pixels) for name, picture, view in seen if view is not None}
        return " and ".join(name for name, blur in blurs.items() if np.isfinite(blur) and blur > MAX_BLUR_PX)

    def _describe(self, pose: Sequence[BoardView | None]) -> str:
        corners = ", ".join(
            f"{name} {'does not see it' if view is None else f'{len(view.ids)} corners'}"
            for name, view in zip(self._names, pose, strict=True)
        )
        return f"{self.kept} kept; {corners}; hold it still at a new place"


def take_pairs(
    guide: Guide, instants: Iterable[Pictures], keep: Callable[[int, Pictures], None], person: SetupPerson
) -> None:
    """Keep pairs with `keep` (number from 1, pictures) until nothing is missing or the cameras end."""
    for pictures in instants:
        judged = guide.judge(pictures)
        if not judged.kept:
            person.show(judged.line)
            continue
        keep(guide.kept, pictures)
        person.tell(f"{judged.line}; {'; '.join(guide.missing[:SHOWN_GAPS]) or 'that is enough'}")
        if not guide.missing:
            return


def judge_rig(rig: Rig, poses: int) -> list[Finding]:
    """Judge whether a rig from a board is as good as usual; where it is not, the likely cause is the cure."""
    rms = {camera.name: camera.reprojection_rms_px for camera in rig.cameras}
    described = ", ".join(f"{name} {value:.2f} px" for name, value in rms.items())
    bad = [name for name, value in rms.items() if value > USUAL_RMS_PX]
    findings = [
        warning("residual", f"{described}; usual is less than {USUAL_RMS_PX:g} px", _likely_cause(bad, len(rms)))
        if bad
        else ok("residual", described)
    ]
    own, left_out = np.linalg.norm(rig.error_rms), np.linalg.norm(rig.leave_one_out_rms or rig.error_rms)
    sentence = f"{1e3 * left_out:.2f} mm at a place that was not used, {1e3 * own:.2f} mm at those that were"
    if left_out > FEW_POSES_RATIO * own:
        findings.append(warning("3D error", f"{sentence}, by {poses} pairs", "take more pairs at more places"))
    else:
        findings.append(ok("3D error", sentence))
    return findings


def _likely_cause(bad: Sequence[str], count: int) -> str:
    if len(bad) < count:
        return (
            f"only the {' and '.join(bad)} camera is off: it was moved, or focuses or stabilises by itself; fix it and "
            "take the pairs again"
        )
    return (
        "the board is not flat, moved while pairs were taken, or its ruler was measured wrongly; glue it on something "
        "stiff, hold it still, and take the pairs again"
    )
