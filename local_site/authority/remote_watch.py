"""The local site's log of the remote one: whether it is there, and the arm's state with its reason."""

from collections.abc import Callable
from dataclasses import dataclass

import structlog

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import MessageError
from common.link.channels import STATE
from common.link.pubsub import Latest
from common.messages.hand import OperatorSettings
from common.messages.robot import SITE_ENDED, Asker, RobotState
from common.process.link_log import LinkLog
from common.process.log import RefusalLog
from common.process.run_summary import RunSummary
from common.process.state_lines import StateLines, counted

CODES_APART_NS = NS_PER_S  # near a limit a reason comes and goes with every sample


@dataclass
class ChannelHealth:
    """The health of a channel: it falls silent `stale_after_ns` after its last message."""

    stale_after_ns: int
    last_ns: int | None = None
    alive: bool = False

    def seen(self, now_ns: int) -> None:
        """A valid message came."""
        self.last_ns = now_ns

    def change(self, now_ns: int) -> bool | None:
        """True when the channel has just come alive, False when it has just fallen silent, None without a change."""
        alive = self.last_ns is not None and now_ns - self.last_ns <= self.stale_after_ns
        if alive == self.alive:
            return None
        self.alive = alive
        return alive


class RemoteWatch:
    """Logs when the remote site comes, falls silent or changes its state, what it finds of the links, and who asks this
    site for the lease.

    `engaged` gets the time of the hand's origin (ns) while the arm obeys this session or waits for it; `state` is what
    was heard last; `summary` counts this session's engagements.
    """

    def __init__(self, states: Latest[RobotState], session: int, engaged: Callable[[int], None]) -> None:
        self._states = states
        self._session = session
        self._engaged = engaged
        self.state: RobotState | None = None
        self._asker: Asker | None = None
        self._health = ChannelHealth(STATE.stale_after_ns)
        self._lines = StateLines()
        self._code: str | None = None
        self._logged_ns = 0
        self._refusals = RefusalLog("state refused")
        self._link_log = LinkLog()
        self.summary = RunSummary()

    @property
    def settings(self) -> OperatorSettings | None:
        """The operator's settings in force at the remote site, as heard last."""
        return self.state.settings if self.state is not None else None

    @property
    def is_there(self) -> bool:
        """Return whether the remote site is heard."""
        return self._health.alive

    def poll(self, now_ns: int) -> None:
        """Take the newest state, and log what has changed."""
        try:
            state = self._states.take()
        except MessageError as error:
            self._refusals.note(error)
            return
        if state is not None:
            self._health.seen(now_ns)
            self.state = state
            self._log(state, now_ns)
        alive = self._health.change(now_ns)
        if alive is False:
            self._code = None
            self._log_silence()
        elif alive:
            structlog.get_logger().info("the remote site is there")
        if not self._health.alive:
            self.summary.note(None, now_ns)

    def _log_silence(self) -> None:
        """Log that no state comes any more; the last one may have said why."""
        if self.state is not None and self.state.code == SITE_ENDED:
            structlog.get_logger().info("the remote site has ended", reason=self.state.reason)
        else:
            structlog.get_logger().warning("the remote site is silent", for_ms=STATE.stale_after_ns // NS_PER_MS)

    def _log(self, state: RobotState, now_ns: int) -> None:
        changes, apart_ns = self._lines.note(state.state, now_ns), now_ns - self._logged_ns
        if changes or self._code is None or (state.code != self._code and apart_ns >= CODES_APART_NS):
            self._code, self._logged_ns = state.code, now_ns
            fields = {"state": state.state.value, "code": state.code, "reason": state.reason}
            structlog.get_logger().info("remote", **fields, **counted(changes))
        ready = state.readiness
        self._link_log.note_limit(state.age_limit_ms, state.speed_scale, ready.code, ready.reason)
        lease = state.lease
        ours = lease is not None and lease.session == self._session
        self.summary.note(state if ours else None, now_ns)
        self._link_log.note(state.hand_link if ours else None, state.video_link, now_ns)
        if ours and state.engagement is not None:
            self._engaged(state.engagement.hand_capture_ns)
        asker = lease.asked_by if lease is not None and ours else None
        if asker is not None and asker != self._asker:
            structlog.get_logger().warning(
                "another operator asks for the arm", name=str(asker), consent=f"farhand lease give {asker.name}"
            )
        self._asker = asker
