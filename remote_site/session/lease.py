"""The lease of the cell: one operator at a time, for a few seconds, renewed, handed over only with consent; pure."""

from dataclasses import dataclass

from common.messages.robot import site_words
from remote_site.reasons import Code, Reason, reason


@dataclass(frozen=True, slots=True)
class Holder:
    """A local site: the session number of its start, and its operator's name."""

    session: int
    name: str

    def __str__(self) -> str:
        return site_words(self.name, self.session)


@dataclass(frozen=True, slots=True)
class Lease:
    """The right to operate, until `expires_ns`; no two leases ever have the same number."""

    number: int
    holder: Holder
    expires_ns: int


@dataclass(frozen=True, slots=True)
class LeaseStatus:
    """The lease in force, and who waits for the holder's consent to take it over; each None if there is none."""

    lease: Lease | None = None
    asker: Holder | None = None


class LeaseServer:
    """Grants, renews, ends and hands over the one lease; time comes in as nanoseconds of the remote site's clock.

    Numbers rise from `first_number`, which has to differ between starts, so that a lease of an earlier start is never
    taken for one of this.
    """

    def __init__(self, duration_ns: int, first_number: int) -> None:
        self.duration_ns = duration_ns
        self._next_number = first_number
        self._lease: Lease | None = None
        self._asker: Holder | None = None
        self._asked_until_ns = 0

    def current(self, now_ns: int) -> Lease | None:
        """The lease in force, None without one."""
        return self._lease if self._lease is not None and now_ns < self._lease.expires_ns else None

    def asker(self, now_ns: int) -> Holder | None:
        """Return who was refused in the last seconds because another holds the lease, and waits for consent."""
        return self._asker if self.current(now_ns) is not None and now_ns < self._asked_until_ns else None

    def status(self, now_ns: int) -> LeaseStatus:
        """The lease in force and who asks for it."""
        return LeaseStatus(self.current(now_ns), self.asker(now_ns))

    def acquire(self, asker: Holder, now_ns: int) -> Lease | Reason:
        """A new lease if no other site holds one; the holder's own is renewed. A refusal names the holder.

        Of several who ask, the first is named while they keep asking: whom the holder consents to must not change
        at the moment of the consent.
        """
        current = self.current(now_ns)
        if current is None:
            return self._grant(asker, now_ns)
        if current.holder == asker:
            return self._extend(current, now_ns)
        named = self.asker(now_ns)
        if named is None or named == asker:
            self._asker, self._asked_until_ns = asker, now_ns + self.duration_ns
        return reason(Code.NOT_HOLDER, holder=current.holder)

    def renew(self, number: int, client: Holder, now_ns: int) -> Lease | Reason:
        """Extend the same lease; one that has ended has to be acquired again."""
        held = self.in_force(number, client, now_ns)
        return self._extend(held, now_ns) if isinstance(held, Lease) else held

    def release(self, number: int, client: Holder, now_ns: int) -> Lease | Reason:
        """End the lease and return it; a refusal when it is not in force."""
        held = self.in_force(number, client, now_ns)
        if isinstance(held, Lease):
            self._lease = None
        return held

    def hand_over(self, number: int, client: Holder, to: Holder | None, now_ns: int) -> Lease | Reason:
        """The holder consents: the lease goes, under a new number, to who asks for it, if that is who was named."""
        held = self.in_force(number, client, now_ns)
        if isinstance(held, Reason):
            return held
        asker = self.asker(now_ns)
        if asker is None:
            return reason(Code.NOBODY_ASKS)
        return self._grant(asker, now_ns) if asker == to else reason(Code.ASKER_CHANGED, asker=asker)

    def in_force(self, number: int, client: Holder, now_ns: int) -> Lease | Reason:
        """The lease that a local site refers to if it is in force, or why what is sent under it is refused."""
        return checked(self.current(now_ns), number, client)

    def _grant(self, holder: Holder, now_ns: int) -> Lease:
        self._lease = Lease(self._next_number, holder, now_ns + self.duration_ns)
        self._next_number += 1
        self._asker = None
        return self._lease

    def _extend(self, lease: Lease, now_ns: int) -> Lease:
        self._lease = Lease(lease.number, lease.holder, now_ns + self.duration_ns)
        return self._lease


def checked(current: Lease | None, number: int, client: Holder) -> Lease | Reason:
    """The lease in force if a local site holds it and refers to it by its number; else why what it sends is refused."""
    if current is not None and (number, client) == (current.number, current.holder):
        return current
    if current is not None and number == current.number:
        return reason(Code.NOT_HOLDER, holder=current.holder)
    if number != 0:
        return reason(Code.OLD_LEASE, number=number)
    return reason(Code.NO_LEASE) if current is None else reason(Code.NOT_HOLDER, holder=current.holder)
