"""Runs Farhand's command line with a simulated operator whose hand another program of this host leads.

python -m lab.experiments.placing.live.led_local SOCKET local --set ...
"""

import sys
from unittest.mock import patch

from common.clock import Clock
from farhand.__main__ import main
from lab.experiments.placing.live.led_hand import LedHand
from local_site.acquisition.rig_cameras import OperatorConfig, OperatorRig, film
from local_site.acquisition.simulated_cameras import Beginning
from local_site.runtime import app
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import make_operator
from local_site.tracking.choice import TrackingConfig


def run() -> None:
    """The command line of Farhand, with this hand before the simulated cameras."""
    name = sys.argv.pop(1)

    def open_operator(
        _: OperatorConfig, simulation: SimulationConfig, tracking: TrackingConfig, __: Clock
    ) -> OperatorRig:
        return film_led(name, simulation, tracking)

    with patch.object(app, "open_operator", open_operator):
        main()


def film_led(name: str, simulation: SimulationConfig, tracking: TrackingConfig) -> OperatorRig:
    """Simulated cameras before an operator whose hand is led from their start on."""
    beginning = Beginning()
    hand = LedHand(name, lambda t_s: beginning.time_ns(t_s + simulation.motion.still_s))
    return film(simulation, tracking, make_operator(simulation, hand), beginning)


if __name__ == "__main__":
    run()
