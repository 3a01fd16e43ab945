"""Policy of the local site's lease of the cell: when to acquire it, and when to renew it; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_S
from common.messages.requests import LeaseAction, LeaseReply

ASK_EVERY_NS = NS_PER_S
RENEWALS_PER_LEASE = 5
KEEP_ASKING_NS = 60 * NS_PER_S


@dataclass(frozen=True, slots=True)
class HeldLease:
    """The lease that this site holds; times by its own clock, counted from the request, so that it never ends late."""

    number: int
    expires_ns: int
    renew_ns: int


class LeasePolicy:
    """Decides when to acquire and renew the lease; gives up when another operator holds it, except after `keep_asking`.

    With `automatic` it asks whenever this site holds no lease. A refusal that names another operator ends that, and so
    does another host of the same name: no site should become the operator only because the other's link was down for a
    few seconds. So does `stop_asking`. Once the operator has taken the lease again, all is as at the start.
    """

    def __init__(self, operator: str, *, automatic: bool) -> None:
        self.operator = operator
        self._automatic = self.asks_by_itself = automatic
        self._ask_until_ns = 0
        self._asked_ns: int | None = None
        self._lease: HeldLease | None = None
        self._namesake: tuple[int, int] | None = None  # the session of our name that holds it, and until when, ns

    def held(self, now_ns: int) -> int:
        """The number of the lease in force, 0 without one."""
        lease = self._lease
        return lease.number if lease is not None and now_ns < lease.expires_ns else 0

    def due(self, now_ns: int) -> LeaseAction | None:
        """Return what to request from the remote site now; None for nothing."""
        if self._lease is not None and now_ns >= self._lease.expires_ns:
            self._lease = None
        if self._lease is not None:
            return LeaseAction.RENEW if now_ns >= self._lease.renew_ns else None
        wanted = self.asks_by_itself or now_ns < self._ask_until_ns
        rested = self._asked_ns is None or now_ns - self._asked_ns >= ASK_EVERY_NS
        return LeaseAction.ACQUIRE if wanted and rested else None

    def asked(self, now_ns: int) -> None:
        """A request is sent now, whether or not it will be answered."""
        self._asked_ns = now_ns
        if self._lease is not None:
            renew_ns = now_ns + (self._lease.expires_ns - now_ns) // RENEWALS_PER_LEASE
            self._lease = HeldLease(self._lease.number, self._lease.expires_ns, renew_ns)

    def take_reply(self, reply: LeaseReply, asked_ns: int, now_ns: int) -> None:
        """Take the reply to a request that was sent at `asked_ns`."""
        if reply.lease:
            step_ns = reply.lasts_ns // RENEWALS_PER_LEASE
            self._lease = HeldLease(reply.lease, asked_ns + reply.lasts_ns, asked_ns + step_ns)
            if self._ask_until_ns:
                self.asks_by_itself, self._ask_until_ns = self._automatic, 0
            return
        self._lease = None
        if reply.holder and (reply.holder != self.operator or self._is_renewed(reply, asked_ns, now_ns)):
            self.asks_by_itself = False

    def keep_asking(self, now_ns: int) -> None:
        """The operator wants the lease: keep asking for a minute, so that its holder can consent."""
        if now_ns >= self._ask_until_ns:
            self._ask_until_ns = now_ns + KEEP_ASKING_NS
        self._asked_ns = None

    def stop_asking(self) -> None:
        """The operator gives the lease away: do not ask for it again automatically."""
        self.asks_by_itself = False
        self._ask_until_ns = 0

    def _is_renewed(self, reply: LeaseReply, asked_ns: int, now_ns: int) -> bool:
        """Return whether another session renewed the lease of our name, so that it is no former one of ours.

        The reply was made between `asked_ns` and `now_ns`.
        """
        before, self._namesake = self._namesake, (reply.holder_session, now_ns + reply.lasts_ns)
        return before is not None and before[0] == reply.holder_session and asked_ns + reply.lasts_ns > before[1]
