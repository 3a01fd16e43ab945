"""What observation points say of a link's motion: intensity errors, their gradients, summed to normal equations.

The report's equation 12 with its errata: the errors go by -dI/dB, the third term has the depth squared, and the turn
about z is gx ry - gy rx.
"""

import math

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled

MOTION, LIGHT = 6, 4
UNKNOWNS = MOTION + LIGHT

Picture = NDArray[np.float32]
Surface = tuple[Array, Array, Array]
Sums = tuple[Array, Array, Array]


@compiled
def fill_observation(row: Array, gradient: Array, focal: Array, point: Array, arm: Array) -> None:
    """How the intensity error at a point falls with the link's motion: translation in m, turn in rad (eq. 12).

    Fills the first six of `row`. `gradient` (2,) is the picture's per px, `focal` (2,) in px, `point` (3,) in the
    camera's frame in m, and `arm` (3,) the point's place from the joint.
    """
    x, y, z = point[0], point[1], point[2]
    rx, ry, rz = arm[0], arm[1], arm[2]
    gx, gy = gradient[0] * focal[0], gradient[1] * focal[1]
    near = 1.0 / z
    radial = (gx * x + gy * y) * near
    row[0], row[1], row[2] = -gx * near, -gy * near, radial * near
    row[3] = (radial * ry + gy * rz) * near
    row[4] = -(radial * rx + gx * rz) * near
    row[5] = (gx * ry - gy * rx) * near


@compiled
def sample(picture: Picture, x: float, y: float) -> float:
    """The picture between its pixels, bilinear; the place must be inside."""
    left, top = int(x), int(y)
    u, v = x - left, y - top
    upper = (1.0 - u) * picture[top, left] + u * picture[top, left + 1]
    lower = (1.0 - u) * picture[top + 1, left] + u * picture[top + 1, left + 1]
    level: float = (1.0 - v) * upper + v * lower
    return level


@compiled
def samples(picture: Picture, x: Array, y: Array) -> Array:
    """The picture at places (N,), those outside moved to its border."""
    height, width = picture.shape
    levels = np.empty(len(x))
    for n in range(len(x)):
        levels[n] = sample(picture, min(max(x[n], 0.0), width - 1.001), min(max(y[n], 0.0), height - 1.001))
    return levels


@compiled
def turned(result: Array, rotation: Array, vector: Array) -> None:
    """The vector (3,) turned, into `result`; a matrix product would cost an array for each point."""
    for k in range(3):
        result[k] = rotation[k, 0] * vector[0] + rotation[k, 1] * vector[1] + rotation[k, 2] * vector[2]


@compiled
def add_point(matrix: Array, right: Array, row: Array, weight: float, error: float) -> None:
    """One point's share of the normal equations, in the upper half of the matrix."""
    for i in range(UNKNOWNS):
        weighted = weight * row[i]
        right[i] += weighted * error
        for j in range(i, UNKNOWNS):
            matrix[i, j] += weighted * row[j]


@compiled
def summed(
    surface: Surface,
    link: tuple[Array, Array, Array],
    view: tuple[Picture, Picture, Picture, Array, Array],
    variances: Array,
    huber: float,
) -> Sums:
    """Normal matrix (10, 10), right side (10,) and statistics (4,) of a link's observation points.

    `surface`: points (N, 3) and normals (N, 3) in the link's frame, reflectances (N,) in grey levels. `link`: its joint
    (3,), its rotation (3, 3) and the light (4,) on it. `view`: the picture and its gradients along x and y, focal
    lengths (2,) and principal point (2,) in its px. `variances`: camera noise in grey² and position error (3,) in m²
    (section 2.3). Unknowns: motion (6,), then the light's change. Statistics: how many points lie inside the picture,
    their mean squared error in grey², clipped after Huber, the same by its variance, the share within three sigma.
    """
    points, normals, reflectances = surface
    joint, rotation, light = link
    picture, along_x, along_y, focal, principal = view
    height, width = picture.shape
    matrix, right = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    row, gradient, point = np.empty(UNKNOWNS), np.empty(2), np.empty(3)
    arm, normal = np.empty(3), np.empty(3)
    seen, squares, scaled, near = 0, 0.0, 0.0, 0
    for n in range(len(points)):
        turned(arm, rotation, points[n])
        for k in range(3):
            point[k] = joint[k] + arm[k]
        u = focal[0] * point[0] / point[2] + principal[0]
        v = focal[1] * point[1] / point[2] + principal[1]
        if not (point[2] > 0.0 and 0.0 <= u < width - 1 and 0.0 <= v < height - 1):
            continue
        gradient[0], gradient[1] = sample(along_x, u, v), sample(along_y, u, v)
        fill_observation(row, gradient, focal, point, arm)
        turned(normal, rotation, normals[n])
        row[MOTION], lit, variance = reflectances[n], light[0], variances[0]
        for k in range(3):
            row[MOTION + 1 + k] = reflectances[n] * normal[k]
            lit += light[1 + k] * normal[k]
            variance += row[k] * row[k] * variances[1 + k]
        error = sample(picture, u, v) - lit * reflectances[n]
        deviation = abs(error) / math.sqrt(variance)
        robust = 1.0 if deviation <= huber else huber / deviation
        clipped = deviation * deviation if deviation <= huber else huber * (2.0 * deviation - huber)
        add_point(matrix, right, row, robust / variance, error)
        seen += 1
        squares += clipped * variance
        scaled += clipped
        near += deviation <= 3.0
    for i in range(1, UNKNOWNS):
        for j in range(i):
            matrix[i, j] = matrix[j, i]
    count = max(seen, 1)
    return matrix, right, np.array([seen, squares / count, scaled / count, near / count])
