"""One view's part in finding the arm: where to look, what is learned of its colours, and the silhouette."""

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.foreground.arm_colour import ArmColour, Positions
from local_site.tracking.foreground.growing import Region, bones, grow, zones
from local_site.tracking.foreground.likelihood import log_ratios
from local_site.tracking.foreground.outline import find_outline
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.foreground.room import Behind, Mask, Place, Room
from local_site.tracking.foreground.tubes import ArmTubes, RatioMap, px_per_m

SQUARE_M = 0.004  # the side of a square at the hand
MOST_STRIDE = 8
REACH_M, MARGIN_M = 0.55, 0.06
ELBOW_M = 0.28  # around the elbow, for the upper arm
REST_STRIDE = 7  # px between the pixels that are counted as the rest
KEPT, LEARN_EVERY = 0.9, 8


class ArmView:
    """Finds the arm in the pictures of one camera with a projection (3, 4)."""

    def __init__(self, projection: Array) -> None:
        self._projection = projection
        self._colour = ArmColour()
        self._room: Room | None = None
        self._map: RatioMap | None = None
        self._colours: Image = np.empty((0, 0, 3), np.uint8)
        self._behind: Behind | None = None
        self._hand: Array = np.empty((0, 2))
        self._pairs = 0

    def learn_room(self, picture: Image) -> None:
        """Learn the room from a picture (H, W, 3) without the arm."""
        self._room_for(picture).learn(picture)

    def look(self, picture: Image, hand: Array, wrist: Array, before: ArmTubes | None) -> RatioMap:
        """Log ratios around the arm, whose hand has landmarks at pixels (21, 2) and a wrist (3,) in m."""
        room = self._room_for(picture)
        left, top, columns, rows, stride = self._box(picture, hand, wrist, before)
        part = picture[top : top + rows * stride, left : left + columns * stride]
        self._colours = np.asarray(cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA), dtype=np.uint8)
        place = left, top, stride
        empty = RatioMap(self._projection, np.zeros((rows, columns), np.float32), *place)
        if not self._colour.is_known:
            on_hand = _positions(bones(empty, hand), place)
            everywhere = np.zeros(picture.shape[:2], np.uint8)
            self._colour.learn(picture, on_hand, _elsewhere(everywhere), 0.0)
        tables = self._colour.arm, self._colour.rest
        maybe = zones(empty, hand, before) if before is not None else np.ones((rows, columns), np.uint8)
        self._behind = room.behind(self._colours, maybe, place)
        ratios = log_ratios(self._colours, self._behind.colours, self._behind.known, tables)
        self._hand = hand
        self._map = RatioMap(self._projection, ratios, *place)
        return self._map

    def silhouette(self, picture: Image, tubes: ArmTubes) -> Silhouette | str:
        """The arm's silhouette in the picture that was looked at last, or why it is not to be trusted."""
        view, room = self._map, self._room
        if view is None or room is None or self._behind is None:
            return ForegroundReason.NOT_SEEN
        region = grow(view, self._hand, tubes)
        tables = self._colour.arm, self._colour.rest
        place = view.place
        found = find_outline(picture, self._colours, region.arm, place, room, self._behind, tables)
        if found is None:
            return ForegroundReason.HAND_CUT
        self._learn(picture, region, place, room)
        return found

    def _learn(self, picture: Image, region: Region, place: Place, room: Room) -> None:
        left, top, stride = place
        rows, columns = region.arm.shape
        near = np.zeros(room.seen.shape, np.uint8)
        could_be = cv2.max(region.arm, cv2.threshold(region.zones, 0, 1, cv2.THRESH_BINARY)[1])
        near[top : top + rows * stride, left : left + columns * stride] = cv2.resize(
            could_be, (columns * stride, rows * stride), interpolation=cv2.INTER_NEAREST
        )
        room.follow(picture, near)
        self._pairs += 1
        if self._pairs < LEARN_EVERY or self._pairs % LEARN_EVERY == 0:
            sure = cv2.erode(region.arm, np.ones((3, 3), np.uint8)) * (region.zones >= 2)
            self._colour.learn(picture, _positions(sure, place), _elsewhere(near), KEPT)

    def _room_for(self, picture: Image) -> Room:
        shape = (picture.shape[0], picture.shape[1])
        if self._room is None or self._room.seen.shape != shape:
            self._room = Room(shape)
        return self._room

    def _box(
        self, picture: Image, hand: Array, wrist: Array, before: ArmTubes | None
    ) -> tuple[int, int, int, int, int]:
        """Left and top in px, columns and rows of squares, and a square's side in px: what the arm can reach."""
        metre = px_per_m(self._projection, wrist)
        stride = min(max(round(SQUARE_M * metre), 1), MOST_STRIDE)
        if before is None:
            corners, margin = hand, REACH_M * metre
        else:
            elbow = before.forearm.end
            around = ELBOW_M * px_per_m(self._projection, elbow)
            limbs = project(self._projection, elbow) + np.array([(-around, -around), (around, around)])
            corners, margin = np.vstack([hand, limbs]), MARGIN_M * metre
        height, width = picture.shape[:2]
        low = np.clip(corners.min(axis=0) - margin, 0, (width - 2 * stride, height - 2 * stride)).astype(int)
        high = np.clip(corners.max(axis=0) + margin, low + stride, (width, height)).astype(int)
        left, top = (low // stride * stride).tolist()
        columns, rows = ((high - (left, top)) // stride).tolist()
        return left, top, columns, rows, stride


def _positions(squares: Mask, place: Place) -> Positions:
    """One pixel (N, 2) of each square (h, w) that is set."""
    left, top, stride = place
    j, i = np.nonzero(squares)
    return np.column_stack([left + i * stride + stride // 2, top + j * stride + stride // 2]).astype(np.int32)


def _elsewhere(arm: Mask) -> Positions:
    """Pixels (M, 2), some px apart, where `arm` (H, W) is 0."""
    j, i = np.nonzero(arm[::REST_STRIDE, ::REST_STRIDE] == 0)
    return np.column_stack([i, j]).astype(np.int32) * REST_STRIDE
