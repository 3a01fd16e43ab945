"""The arm's pose from one silhouette: the meshes' outline fitted to the picture's by least squares.

Lengths and positions in the picture give the distance; the direction in which a limb tapers gives the sign of its tilt.
A tilt is observable to some degrees only, hence the prior that the links are nearly parallel to the picture.
"""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from common.geometry import Array
from local_site.calibration.physical_camera import Lens
from local_site.kernels.pictures import Levels, greys_at
from local_site.tracking.config import MonocularConfig
from local_site.tracking.features.features import Features
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.monocular.arm_model import MM, ArmPose, Link, Profile, facing, forearm_mesh, upper_arm_mesh

INSIDE_PX = 1.0

Mask = NDArray[np.bool_]


def sides_of(profile: Profile, link: Link, lens: Lens) -> Array:
    """Both sides (2, N, 2) of a link's outline in px, in order along it; NaN for a link seen from inside.

    These are the points where lines of sight are tangent to its elliptic sections.
    The taper, which is neglected, moves the outline by less than a tenth of a pixel.
    """
    joint, rotation = link
    x, y, _ = (-rotation.T @ joint).tolist()
    across, deep = x / profile.across, y / profile.deep
    with np.errstate(invalid="ignore"):
        half = np.arccos(1.0 / np.hypot(across, deep))
    turns = np.arctan2(deep, across) + np.array([[-1.0], [1.0]]) * half
    along = np.broadcast_to(profile.along, turns.shape)
    points = np.stack([profile.across * np.cos(turns), profile.deep * np.sin(turns), along], axis=-1)
    in_camera = points @ rotation.T + joint
    pixels: Array = in_camera[..., :2] / in_camera[..., 2:] * (lens.fx, lens.fy) + (lens.cx, lens.cy)
    return pixels


def hidden(points: Array, sides: Array) -> Mask:
    """Return which pixels (..., 2) lie well inside a link's outline (2, N, 2)."""
    outline = np.concatenate([sides[0], sides[1, ::-1]]).astype(np.float32)[:, None]
    inside = [cv2.pointPolygonTest(outline, (x, y), True) > INSIDE_PX for x, y in points.reshape(-1, 2).tolist()]
    return np.array(inside).reshape(points.shape[:-1])


TILT_SIGMA, FREE_TILT_SIGMA = math.radians(8.0), math.radians(25.0)
GIRTH_SIGMA, TURN_SIGMA = 0.04, 1.0
# The shape's errors at neighbouring sections are correlated, so that each has less weight than its pixels would give.
EDGE_SIGMA_PX = 2.0
SHOULDER_SIGMA = 0.05  # of the upper arm's length: the error of the joint's position relative to its end
PALM_FRACTION = 0.75
BORDER_PX = 3
# The silhouette begins where a blurred edge (0.8 px) has risen by 15 %, which is outside its steepest point.
EDGE_OUTSIDE_PX = 0.8
ROUNDS, EVALUATIONS = 3, 6
# Slopes of the elbow's line of sight, log of its depth, angle and tilt of both links, palm rotation, girths' error.
SCALES = np.array([0.01, 0.01, 0.03, 0.05, 0.1, 0.05, 0.1, 0.2, 0.03, 0.03])
ELBOW, DEPTH, UPPER, FOREARM, TURN, GIRTHS = slice(0, 2), 2, slice(3, 5), slice(5, 7), 7, slice(8, 10)
TILTS = [4, 6]
TRIED_TILTS = ((0.0, 0.0), (0.35, 0.35), (-0.35, 0.35), (0.35, -0.35), (-0.35, -0.35))
STEP = 1e-5


@dataclass(frozen=True, slots=True)
class OutlineFit:
    """A pose, and its quality.

    Standard deviations (3,) in m of shoulder, elbow and wrist; the rms residual of the outline in px, and the number of
    its points seen of each link. Without the prior that the links are nearly parallel to the picture: their tilts out
    of it (2,) in rad, and the change (3,) in m of shoulder, elbow and wrist.
    """

    pose: ArmPose
    sigmas: Array
    rms_px: float
    points: tuple[int, int]
    free_tilts: Array
    free_moves: Array


@dataclass(frozen=True, slots=True)
class _Target:
    """The target of the fit: features, signed distance in px of each pixel (H, W) to the edge, tilts' sigma in rad."""

    features: Features
    distances: Levels
    tilt_sigma: float


class OutlineFitter:
    """Fits both links' outline in a pinhole camera."""

    def __init__(self, lens: Lens, config: MonocularConfig) -> None:
        self._lens, self._palm_turn = lens, math.radians(config.start.palm_turn_deg)
        self._upper_arm, self._forearm = upper_arm_mesh(config.upper_arm), forearm_mesh(config.forearm)
        self._wrist = np.array([0.0, 0.0, self._forearm.length])
        of, knuckles = self._forearm.sections, self._forearm.length + PALM_FRACTION * MM * config.forearm.palm_length_mm
        kept = of.along <= knuckles
        self._profiles = self._upper_arm.sections, Profile(of.along[kept], of.across[kept], of.deep[kept])

    def fit(self, features: Features) -> OutlineFit:
        """The pose whose outline is nearest to the silhouette's, starting from its features."""
        near = _Target(features, _distances(features.silhouette), TILT_SIGMA)
        first, solutions = self._first(features), []
        for tilts in TRIED_TILTS:  # each sign of the tilts has its own local minimum
            tilted = first.copy()
            tilted[TILTS] = tilts
            solutions.append(self._solved(tilted, replace(near, tilt_sigma=FREE_TILT_SIGMA)))
        free = min(solutions, key=lambda solution: solution[2])[0]
        unknowns, jacobian, _ = self._solved(free, near)
        return self._result(unknowns, jacobian, near, free)

    def _solved(self, unknowns: Array, target: _Target) -> tuple[Array, Array, float]:
        """The unknowns (10,), the residuals' Jacobian (R, 10) there, and half the sum of their squares.

        Occlusion is updated between rounds.
        """
        jacobian, cost = np.zeros((0, len(unknowns))), math.inf
        for _ in range(ROUNDS):
            seen = self._seen(unknowns, target.distances.shape)
            found = least_squares(self._residuals, unknowns, args=(target, seen), x_scale=SCALES, max_nfev=EVALUATIONS)
            unknowns, jacobian = found.x, np.asarray(found.jac)
            cost = float(found.cost)
        return unknowns, jacobian, cost

    def _first(self, features: Features) -> Array:
        """Both links parallel to the picture."""
        guess = features.guess
        shoulder, elbow, wrist = (self._slope(pixel) for pixel in (guess.shoulder_end, guess.elbow, guess.wrist))
        upper, lower = elbow - shoulder, wrist - elbow
        depth = self._forearm.length / float(np.linalg.norm(lower))
        upper_angle, lower_angle = (math.atan2(along[1], along[0]) for along in (upper, lower))
        across, down = elbow.tolist()
        return np.array([across, down, math.log(depth), upper_angle, 0, lower_angle, 0, self._palm_turn, 0, 0])

    def _slope(self, pixel: Array) -> Array:
        lens = self._lens
        result: Array = (pixel - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
        return result

    def _pose(self, unknowns: Array) -> ArmPose:
        elbow = math.exp(unknowns[DEPTH]) * np.array([*unknowns[ELBOW], 1.0])
        upper_arm = facing(_direction(*unknowns[UPPER]), 0.0)
        forearm = facing(_direction(*unknowns[FOREARM]), unknowns[TURN])
        length = self._upper_arm.length
        return ArmPose(elbow - length * upper_arm[:, 2], upper_arm, forearm, length)

    def _joints(self, unknowns: Array) -> Array:
        """Shoulder, elbow and wrist (9,), m."""
        pose = self._pose(unknowns)
        return np.concatenate([pose.shoulder, pose.elbow, pose.on_forearm(self._wrist)])

    def _sides(self, unknowns: Array) -> list[Array]:
        return [
            sides_of(Profile(of.along, (1.0 + girth) * of.across, (1.0 + girth) * of.deep), link, self._lens)
            for of, girth, link in zip(self._profiles, unknowns[GIRTHS], self._pose(unknowns).links, strict=True)
        ]

    def _seen(self, unknowns: Array, shape: tuple[int, ...]) -> tuple[Mask, Mask]:
        """Return which points of both links' outlines lie in the picture and not inside the other link."""
        upper, forearm = self._sides(unknowns)
        return _inside(upper, shape) & ~hidden(upper, forearm), _inside(forearm, shape) & ~hidden(forearm, upper)

    def _residuals(self, unknowns: Array, target: _Target, seen: tuple[Mask, Mask]) -> Array:
        """The robust distance of each outline point from the silhouette's edge, and the priors' residuals."""
        pairs = zip(self._sides(unknowns), seen, strict=True)
        off = np.concatenate(
            [np.where(mask, _distances_at(target.distances, sides), 0.0).ravel() for sides, mask in pairs]
        )
        expected = np.concatenate(
            [
                unknowns[TILTS] / target.tilt_sigma,
                unknowns[GIRTHS] / GIRTH_SIGMA,
                [(unknowns[TURN] - self._palm_turn) / TURN_SIGMA, self._shoulder_off(unknowns, target.features)],
            ]
        )
        return np.concatenate([_robust(off / EDGE_SIGMA_PX), expected])

    def _shoulder_off(self, unknowns: Array, features: Features) -> float:
        """The residual of the upper arm's end from the silhouette's, along it; 0 if the border cuts it."""
        if features.silhouette.at_border or features.upper_arm is None:
            return 0.0
        cap = 0.5 * float(self._profiles[0].deep[0])
        end = self._pose(unknowns).on_upper_arm(np.array([0.0, 0.0, -cap]))
        focal = np.array([self._lens.fx, self._lens.fy])
        off_px = (self._slope(features.guess.shoulder_end) - end[:2] / end[2]) * focal
        length_px = self._lens.fx * self._upper_arm.length / end[2]
        return float(off_px @ features.upper_arm.direction / (SHOULDER_SIGMA * length_px))

    def _result(self, unknowns: Array, jacobian: Array, target: _Target, free: Array) -> OutlineFit:
        seen = self._seen(unknowns, target.distances.shape)
        pairs = zip(self._sides(unknowns), seen, strict=True)
        off = np.concatenate([_distances_at(target.distances, sides)[mask] for sides, mask in pairs])
        joints = self._joints(unknowns)
        moves = np.column_stack([(self._joints(unknowns + h) - joints) / STEP for h in STEP * np.eye(len(SCALES))])
        spread = moves @ np.linalg.pinv(jacobian.T @ jacobian) @ moves.T
        return OutlineFit(
            self._pose(unknowns),
            np.sqrt(np.diag(spread).reshape(3, 3).sum(axis=1)),
            float(np.sqrt(np.mean(off**2))) if len(off) else math.inf,
            (int(seen[0].sum()), int(seen[1].sum())),
            free[TILTS],
            np.linalg.norm((self._joints(free) - joints).reshape(3, 3), axis=1),
        )


def _direction(angle: float, tilt: float) -> Array:
    """The unit vector (3,) at an angle in the picture and a tilt away from the camera, rad."""
    flat = math.cos(tilt)
    return np.array([flat * math.cos(angle), flat * math.sin(angle), math.sin(tilt)])


def _distances(silhouette: Silhouette) -> Levels:
    """The distance of each pixel (H, W) to the silhouette's edge, px; negative outside."""
    filled = np.zeros(silhouette.grey.shape, np.uint8)
    cv2.drawContours(filled, [silhouette.contour.astype(np.int32)], -1, 255, cv2.FILLED)
    within, beyond = (cv2.distanceTransform(mask, cv2.DIST_L2, 5) for mask in (filled, 255 - filled))
    inward = np.where(filled > 0, within - 0.5, 0.5 - beyond) - EDGE_OUTSIDE_PX
    return inward.astype(np.float32)


def _distances_at(distances: Levels, pixels: Array) -> Array:
    x, y = np.nan_to_num(pixels).reshape(-1, 2).T.copy()
    return greys_at(distances, x, y).reshape(pixels.shape[:-1])


def _inside(sides: Array, shape: tuple[int, ...]) -> Mask:
    height, width = shape
    x, y = sides[..., 0], sides[..., 1]
    result: Mask = (x > BORDER_PX) & (x < width - 1 - BORDER_PX) & (y > BORDER_PX) & (y < height - 1 - BORDER_PX)
    return result


def _robust(off: Array) -> Array:
    """Pseudo-Huber residuals: their squares grow linearly where they are large."""
    result: Array = np.sign(off) * np.sqrt(2.0 * (np.sqrt(1.0 + off * off) - 1.0))
    return result
