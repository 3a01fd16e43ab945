"""One view's part in finding the arm: where to look, what is learned of its colours, and the silhouette."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.calibration.triangulation import focal_length, project
from local_site.calibration.undistortion import Pixels, TakenPicture, Undistorter
from local_site.tracking.features.silhouette import Silhouette, to_grey
from local_site.tracking.foreground.arm_colour import ArmColour
from local_site.tracking.foreground.growing import LIKELY, NEVER, bones, grow, near_bones, zones
from local_site.tracking.foreground.likelihood import log_ratios, ratio_tables
from local_site.tracking.foreground.outline import find_outline
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.foreground.room import Behind, ColourPlanes, Mask, Place, RoomModel
from local_site.tracking.foreground.trust import AreaWatch, objection
from local_site.tracking.foreground.tubes import ArmTubes, RatioMap, depth_of

SQUARE_M = 0.0045  # the side of a square at the hand
MOST_STRIDE = 8
REACH_M = 0.55  # around the wrist, until the arm was found once
MARGIN_M = 0.06
ELBOW_M = 0.19  # around the elbow, for the upper arm
REST_STRIDE = 7  # px between the pixels that are counted as the rest
KEPT, LEARN_EVERY = 0.9, 8  # pairs; the first ones are all learned


@dataclass(frozen=True, slots=True)
class _Look:
    """What is known of one picture before the arm's region: its part that the arm can reach.

    By squares (h, w): where the hand's bones are and what is near them, log ratios, mean colours, what is behind.
    """

    picture: TakenPicture
    part: Image
    bones: Mask
    near_hand: Mask
    map: RatioMap
    colours: ColourPlanes
    behind: Behind


class ForegroundView:
    """Finds the arm in the pictures of one camera, BGR (H, W, 3) as they were taken."""

    def __init__(self, camera: CameraCalibration) -> None:
        self._projection, self._focal_px = camera.matrix, focal_length(camera.matrix)
        self._undistorter = Undistorter(camera.lens, cv2.BORDER_REPLICATE)
        self._colour = ArmColour()
        self._tables = ratio_tables(self._colour.arm, self._colour.rest)
        self._areas = AreaWatch()
        self._room: RoomModel | None = None
        self._look: _Look | None = None
        self._possible: Mask = np.empty((0, 0), np.uint8)
        self._arm: Mask = self._possible
        self._learned = 0

    def learn_room(self, picture: Image) -> None:
        """Learn the room from a picture without the arm."""
        self._room_for(picture).learn(TakenPicture(picture, self._undistorter))

    def forget(self) -> None:
        """Forget how large the arm was."""
        self._areas = AreaWatch()

    def look(self, taken: Image, hand: Array, wrist: Array, before: ArmTubes | None) -> RatioMap:
        """Log ratios around the arm, 0 on the hand, which has landmarks at undistorted pixels (21, 2) and a wrist (3,)
        in m."""
        room, picture = self._room_for(taken), TakenPicture(taken, self._undistorter)
        left, top, columns, rows, stride = self._box(picture.shape, hand, wrist, before)
        place = left, top, stride
        part = picture.part(slice(top, top + rows * stride), slice(left, left + columns * stride))
        colours = np.array(cv2.split(cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA)), np.uint8)
        unknown = RatioMap(self._projection, self._focal_px, np.zeros((rows, columns), np.float32), *place)
        on_bones, near_hand = bones(unknown, hand), near_bones(unknown, hand, wrist)
        if not self._colour.is_known:
            on_hand = _positions(on_bones, place)
            self._learn_colour(picture, on_hand, np.zeros(picture.shape, np.uint8), 0.0)
        maybe = np.ones((rows, columns), np.uint8) if before is None else zones(unknown, on_bones, near_hand, before)
        behind = room.behind(colours, maybe, place)
        ratios = log_ratios(colours, behind.colours, behind.known, self._tables)
        found = RatioMap(self._projection, self._focal_px, ratios, *place)
        self._look = _Look(picture, part, on_bones, near_hand, found, colours, behind)
        # A tube that runs back over the hand would fit everywhere.
        off_hand = np.where(near_hand > 0, np.float32(0.0), ratios)
        return replace(found, ratios=off_hand)

    def silhouette(self, tubes: ArmTubes) -> Silhouette | ForegroundReason:
        """The arm's silhouette in the picture that was looked at last, or why it is not to be trusted."""
        look, room = self._look, self._room
        if look is None or room is None:
            return ForegroundReason.NOT_SEEN
        self._possible = zones(look.map, look.bones, look.near_hand, tubes)
        self._arm = grow(look.map, self._possible, tubes)
        problem = objection(look.map, (look.bones, look.near_hand), self._arm, tubes) or self._areas.objection(
            self._arm, look.map
        )
        if problem is not None:
            return problem
        found = find_outline(look.part, look.colours, self._arm, look.map.place, room, look.behind, self._tables)
        return ForegroundReason.HAND_CUT if found is None else replace(found, picture=_grey_around(look))

    def learn(self) -> None:
        """Learn the colours of the arm, and the room around it, from the silhouette found last."""
        look, room = self._look, self._room
        if look is None or room is None:
            return
        left, top, stride = look.map.place
        rows, columns = self._arm.shape
        near = np.zeros(room.seen.shape, np.uint8)
        maybe = np.asarray((self._possible != NEVER) | (self._arm > 0), np.uint8)
        near[top : top + rows * stride, left : left + columns * stride] = cv2.resize(
            maybe, (columns * stride, rows * stride), interpolation=cv2.INTER_NEAREST
        )
        room.follow(look.picture, near)
        self._learned += 1
        if self._learned < LEARN_EVERY or self._learned % LEARN_EVERY == 0:
            sure = np.asarray(cv2.erode(self._arm, np.ones((3, 3), np.uint8)), np.uint8) * (self._possible >= LIKELY)
            self._learn_colour(look.picture, _positions(sure, look.map.place), near, KEPT)

    def _learn_colour(self, picture: TakenPicture, on_arm: Pixels, near: Mask, kept: float) -> None:
        self._colour.learn(picture.at(on_arm), picture.at(_elsewhere(near)), kept)
        self._tables = ratio_tables(self._colour.arm, self._colour.rest)

    def _room_for(self, picture: Image) -> RoomModel:
        shape = (picture.shape[0], picture.shape[1])
        if self._room is None or self._room.seen.shape != shape:
            self._room = RoomModel(shape)
        return self._room

    def _box(
        self, shape: tuple[int, int], hand: Array, wrist: Array, before: ArmTubes | None
    ) -> tuple[int, int, int, int, int]:
        """Left and top in px, columns and rows of squares, and a square's side in px: what the arm can reach."""
        px_per_m = self._focal_px / depth_of(self._projection, wrist)
        stride = min(max(round(SQUARE_M * px_per_m), 1), MOST_STRIDE)
        corners, margin = hand, REACH_M * px_per_m
        if before is not None:
            elbow = before.forearm.end
            around = ELBOW_M * self._focal_px / depth_of(self._projection, elbow)
            limbs = project(self._projection, elbow) + np.array([(-around, -around), (around, around)])
            corners, margin = np.vstack([hand, limbs]), MARGIN_M * px_per_m
        height, width = shape
        low = np.clip(corners.min(axis=0) - margin, 0, (width - 2 * stride, height - 2 * stride)).astype(int)
        high = np.clip(corners.max(axis=0) + margin, low + 2 * stride, (width, height)).astype(int)
        left, top = (low // stride * stride).tolist()
        columns, rows = ((high - (left, top)) // stride).tolist()
        return left, top, columns, rows, stride


def _grey_around(look: _Look) -> Mask:
    """The grey picture (H, W) where the arm can be, for edges within it; what is farther off is black."""
    left, top, _ = look.map.place
    grey = np.zeros(look.picture.shape, np.uint8)
    rows, columns = look.part.shape[:2]
    grey[top : top + rows, left : left + columns] = to_grey(look.part)
    return grey


def _positions(squares: Mask, place: Place) -> Pixels:
    """One pixel (N, 2) of each square (h, w) that is set."""
    left, top, stride = place
    j, i = np.nonzero(squares)
    return np.column_stack([left + i * stride + stride // 2, top + j * stride + stride // 2]).astype(np.int32)


def _elsewhere(arm: Mask) -> Pixels:
    """Pixels (M, 2), some px apart, where `arm` (H, W) is 0."""
    j, i = np.nonzero(arm[::REST_STRIDE, ::REST_STRIDE] == 0)
    return np.column_stack([i, j]).astype(np.int32) * REST_STRIDE
