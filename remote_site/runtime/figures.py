"""The remote site's figures for Prometheus: from its published state, and from what the video has sent."""

from collections.abc import Iterator

from prometheus_client import Histogram
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric

from common.clock import NS_PER_S
from common.messages.robot import Obeyed, RobotState, SessionState
from common.process.metrics import gauge, lost_pictures
from remote_site.video.process import VideoTally

LATENCY_BUCKETS_S = (0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5)


class RemoteFigures:
    """Takes every state of the cell; one thread writes, another reads."""

    def __init__(self, video: VideoTally) -> None:
        self._video = video
        self._state: RobotState | None = None
        self._received_ns = 0
        self._entered = dict.fromkeys(SessionState, 0)
        self._obeyed: Obeyed | None = None
        self._latency = Histogram(
            "farhand_capture_to_command_seconds",
            "From the exposure of a hand sample to the first command that obeys it",
            registry=None,
            buckets=LATENCY_BUCKETS_S,
        )

    def observe(self, state: RobotState, now_ns: int) -> None:
        """Take a state that came at this time."""
        before = self._state
        if before is None or before.state is not state.state:
            self._entered[state.state] += 1
        obeyed, clock = state.obeyed, state.clock
        if obeyed is not None and clock is not None and _is_newer(obeyed, self._obeyed):
            self._obeyed = obeyed
            latency_ns = obeyed.command_ns - obeyed.capture_ns - clock.remote_minus_local_ns
            self._latency.observe(latency_ns / NS_PER_S)
        self._state, self._received_ns = state, now_ns

    def families(self, now_ns: int) -> Iterator[Metric]:
        """All figures at this time; without a state, those of the video only."""
        yield from self._of_video(now_ns)
        state = self._state
        if state is None:
            return
        yield gauge(
            "farhand_state_age_seconds", "Since control last published its state", (now_ns - self._received_ns) / 1e9
        )
        yield from self._of_session(state)
        yield from _of_control(state)
        yield from _of_lease(state)
        yield from self._latency.collect()

    def _of_session(self, state: RobotState) -> Iterator[Metric]:
        now = GaugeMetricFamily("farhand_session_state", "1 for the session's state, else 0", labels=["state"])
        entered = CounterMetricFamily("farhand_session_entered", "How often the session came into it", labels=["state"])
        for name, count in self._entered.items():
            now.add_metric([name.value], float(state.state is name))
            entered.add_metric([name.value], count)
        why = GaugeMetricFamily("farhand_session_reason", "1 for the code of the state's reason", labels=["code"])
        why.add_metric([state.code], 1.0)
        rejected = CounterMetricFamily("farhand_hand_rejected", "Hand samples refused", labels=["reason"])
        for reason, count in state.rejected.items():
            rejected.add_metric([reason], count)
        yield from (now, entered, why, rejected)

    def _of_video(self, now_ns: int) -> Iterator[Metric]:
        frames = CounterMetricFamily("farhand_video_frames", "Messages of a camera", labels=["camera", "status"])
        size = CounterMetricFamily("farhand_video_bytes", "Bytes of pictures", labels=["camera"])
        age = GaugeMetricFamily("farhand_video_age_seconds", "Since the newest live picture", labels=["camera"])
        for camera in self._video.cameras:
            tally = self._video.read(camera)
            for status, count in tally.frames.items():
                frames.add_metric([camera, status.value], count)
            size.add_metric([camera], tally.picture_bytes)
            if tally.capture_ns:
                age.add_metric([camera], (now_ns - tally.capture_ns) / NS_PER_S)
        yield from (frames, size, age, lost_pictures(self._video.lost.read()))


def _of_control(state: RobotState) -> Iterator[Metric]:
    timing = state.timing
    yield CounterMetricFamily("farhand_states", "States published by control", value=state.seq)
    yield gauge("farhand_control_rate_hertz", "Ticks per second since the start", timing.hz)
    yield gauge("farhand_control_late_p99_seconds", "Lateness of ticks, 99th percentile", timing.late_p99_us / 1e6)
    yield CounterMetricFamily("farhand_control_ticks", "Ticks of control", value=timing.ticks)
    yield CounterMetricFamily("farhand_control_missed_ticks", "Ticks missed by a whole period", value=timing.missed)
    yield gauge("farhand_control_real_time", "1 when control has real-time scheduling", float(timing.real_time))
    if state.min_distance is not None:
        yield gauge("farhand_least_distance_metres", "From the arm to what it could touch", state.min_distance)


def _of_lease(state: RobotState) -> Iterator[Metric]:
    yield gauge("farhand_ready", "1 when the arm could be engaged", float(state.readiness.ready))
    yield gauge("farhand_lease_held", "1 while an operator holds the lease", float(state.lease is not None))
    if state.clock is not None:
        yield gauge(
            "farhand_clock_uncertainty_seconds", "Of the two hosts' clocks", state.clock.uncertainty_ns / NS_PER_S
        )


def _is_newer(sample: Obeyed, last: Obeyed | None) -> bool:
    return last is None or sample.session != last.session or sample.seq > last.seq
