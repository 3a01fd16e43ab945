"""The cell with the markers of the shipped example of fine adjustment, looked for in its cameras' pictures."""

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, FakeClock
from common.config.loading import load_config
from common.messages.requests import ViewCalibration
from farhand.deployment.shipped import HERE
from lab.experiments.placing.network import Messages, Network
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import SteppedSite
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.video.marker_look import MarkerLook

EXAMPLE = HERE / "sites" / "remote-assist.toml"
LOOK_TAKES_NS = 40 * NS_PER_MS  # from the exposure of a view until control knows what it shows


def with_markers(config: RemoteConfig) -> RemoteConfig:
    """The site with the example's targets, and the markers that they count from."""
    example = load_config(RemoteConfig, EXAMPLE)
    marked = replace(config.simulation, printed_markers=example.simulation.printed_markers)
    return replace(config, assist=example.assist, simulation=marked)


class CellMarkers:
    """The video process's sightings of markers, as they come to control; none where no targets are configured."""

    def __init__(self, config: RemoteConfig, site: SteppedSite[SteppedCell]) -> None:
        self._site, self._sightings = (
            site,
            Messages[Sequence[MarkerSighting]](Network(), np.random.default_rng(0), LOOK_TAKES_NS),
        )
        views: dict[str, ViewCalibration] = {c.name: c.calibration for c in site.description.cameras if c.calibration}
        clock = FakeClock()  # a look takes no time of the simulation's
        look = MarkerLook(config.assist, views, lambda _t_ns: site.model.forward(site.robot.q), self._publish, clock)
        self._look = look if config.assist.targets else None

    def see(self, view: str, frame: Frame | None) -> None:
        """Take a view's newest picture."""
        if self._look is not None:
            self._look.see(view, frame, self._site.now_ns)

    def arrived(self) -> list[MarkerSighting]:
        """Return the sightings that reach control now."""
        return [each for sightings in self._sightings.arrived(self._site.now_ns) for each in sightings]

    def _publish(self, sightings: Sequence[MarkerSighting]) -> None:
        self._sightings.send(sightings, self._site.now_ns)
