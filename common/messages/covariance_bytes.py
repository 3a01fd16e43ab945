"""A point's covariance in six bytes: three standard deviations on a logarithmic scale, and three correlations; pure."""

import math
import struct

from common.errors import MessageError

Numbers = tuple[float, ...]

LEAST_M, STEP = 1e-5, 0.045  # 0.01 mm to 1 m; a step is 4.6 %
STEPS, WHOLE = 255, 127  # of a standard deviation, of a correlation of 1
FORMAT = "<3B3b"


def pack_covariance(covariance: Numbers) -> bytes:
    """Of xx, xy, xz, yy, yz, zz in m²; MessageError where it is not finite or a variance is negative."""
    xx, xy, xz, yy, yz, zz = covariance
    if not all(map(math.isfinite, covariance)):
        raise MessageError("not_finite", "a covariance is not finite")
    if min(xx, yy, zz) < 0:
        raise MessageError("invalid", "a variance is negative")
    x, y, z = (math.sqrt(variance) for variance in (xx, yy, zz))
    correlations = _correlation(xy, x * y), _correlation(xz, x * z), _correlation(yz, y * z)
    return struct.pack(FORMAT, *map(_steps, (x, y, z)), *correlations)


def unpack_covariance(packed: object) -> Numbers:
    """To half a step of each deviation, and to half a percent of the correlations; MessageError for anything else."""
    if not isinstance(packed, bytes) or len(packed) != struct.calcsize(FORMAT):
        raise MessageError("invalid", f"a covariance has {struct.calcsize(FORMAT)} bytes, not {str(packed)[:20]}")
    *steps, xy, xz, yz = struct.unpack(FORMAT, packed)
    if min(xy, xz, yz) < -WHOLE:
        raise MessageError("invalid", "a correlation is less than -1")
    x, y, z = (LEAST_M * math.exp(STEP * step) for step in steps)
    return x * x, x * y * xy / WHOLE, x * z * xz / WHOLE, y * y, y * z * yz / WHOLE, z * z


def _steps(deviation_m: float) -> int:
    if deviation_m <= LEAST_M:
        return 0
    return min(STEPS, round(math.log(deviation_m / LEAST_M) / STEP))


def _correlation(covariance: float, product: float) -> int:
    return round(max(-WHOLE, min(WHOLE, WHOLE * covariance / product))) if product > 0 else 0
