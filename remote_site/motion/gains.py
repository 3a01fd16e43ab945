"""The gains of an alpha-beta estimate, from those at rest to those in motion; pure."""

from remote_site.motion.config import ControlConfig

MEMORY = 0.3  # weight of the newest deviation in the running means: about three count
NOISE_CORRELATION, MOTION_CORRELATION = 0.2, 0.5  # squared mean deviation over mean squared: of noise, of motion
NOTHING = 1e-18  # m² or rad²

Numbers = list[float]


class Gains:
    """They rise with the correlation of successive deviations: deviations to alternating sides are noise."""

    def __init__(self, config: ControlConfig) -> None:
        rest = config.position_gain, config.velocity_gain, config.glide_rad_s
        moving = config.moving_position_gain, config.moving_velocity_gain, config.moving_glide_rad_s
        self._ranges = [(low, max(high, low) - low) for low, high in zip(rest, moving, strict=True)]
        self.rate_at_rest = rest[2]

    def reset(self, size: int) -> None:
        """Nothing has deviated yet."""
        self._deviation, self._square = [0.0] * size, 0.0

    def take(self, error: Numbers) -> Numbers:
        """The gains of position and velocity, and the convergence rate, for the newest deviation (n,)."""
        self._deviation = [old + MEMORY * (new - old) for new, old in zip(error, self._deviation, strict=True)]
        self._square += MEMORY * (_square(error) - self._square)
        correlation = _square(self._deviation) / (self._square + NOTHING)
        motion = min(max((correlation - NOISE_CORRELATION) / (MOTION_CORRELATION - NOISE_CORRELATION), 0.0), 1.0)
        return [low + motion * more for low, more in self._ranges]


def _square(numbers: Numbers) -> float:
    return sum(number * number for number in numbers)
