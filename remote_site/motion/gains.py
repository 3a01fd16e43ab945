"""The gains of an alpha-beta-gamma filter, from those at rest to those in motion; pure."""

from typing import NamedTuple

from remote_site.motion.config import ControlConfig

MEMORY, LONGER_MEMORY = 0.3, 0.2  # weight of the newest deviation in the running means: about three, and five count
NOISE_CORRELATION, MOTION_CORRELATION = 0.2, 0.5  # squared mean deviation over mean squared: of noise, of motion
NOTHING = 1e-18  # m² or rad²

Numbers = list[float]


class FilterGains(NamedTuple):
    """The fractions of a deviation that change the estimate, and the convergence rate in rad/s."""

    position: float
    velocity: float
    acceleration: float
    convergence: float


class Correlation:
    """The agreement of successive deviations: deviations to alternating sides are noise."""

    def __init__(self, size: int, memory: float) -> None:
        self._memory, self._mean, self._square = memory, [0.0] * size, 0.0

    def motion(self, deviation: Numbers) -> float:
        """From 0 for noise to 1 for motion, with the newest deviation (n,)."""
        self._mean = [old + self._memory * (new - old) for new, old in zip(deviation, self._mean, strict=True)]
        self._square += self._memory * (_square(deviation) - self._square)
        correlation = _square(self._mean) / (self._square + NOTHING)
        return min(max((correlation - NOISE_CORRELATION) / (MOTION_CORRELATION - NOISE_CORRELATION), 0.0), 1.0)


class Gains:
    """They rise with the correlation of successive deviations; the acceleration's, which noise hurts most, last."""

    def __init__(self, config: ControlConfig) -> None:
        self._rest = FilterGains(config.position_gain, config.velocity_gain, 0.0, config.glide_rad_s)
        moving = (
            config.moving_position_gain,
            config.moving_velocity_gain,
            config.moving_acceleration_gain,
            config.moving_glide_rad_s,
        )
        self._ranges = [max(high, low) - low for low, high in zip(self._rest, moving, strict=True)]
        self.rate_at_rest = config.glide_rad_s

    def reset(self, size: int) -> None:
        """Nothing has deviated yet."""
        self._moves, self._accelerates = Correlation(size, MEMORY), Correlation(size, LONGER_MEMORY)

    def update(self, deviation: Numbers) -> FilterGains:
        """Return the gains for the newest deviation (n,)."""
        moves, accelerates = self._moves.motion(deviation), self._accelerates.motion(deviation)
        shares = moves, moves, accelerates, moves
        columns = zip(self._rest, self._ranges, shares, strict=True)
        return FilterGains(*(rest + share * more for rest, more, share in columns))


def _square(numbers: Numbers) -> float:
    return sum(number * number for number in numbers)
