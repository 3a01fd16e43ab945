"""Takes the hand samples from the wire: only the lease holder's count, judged one by one, their way measured; pure."""

from collections import Counter

from common.clock import ClockOffset
from common.messages.hand import ClockSync, HandPoint
from common.messages.robot import HandLink
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimit, AgeLimitChoice
from remote_site.session.hand_link_meter import HandLinkMeter
from remote_site.session.lease import Holder, Lease, checked
from remote_site.session.samples import Accepted, NamedSample, Rejected
from remote_site.teleop.sample_validator import SampleValidator, clock_offset


class SampleReceiver:
    """`latest` is the newest sample that may be followed."""

    def __init__(self, safety: SafetyConfig, point: HandPoint) -> None:
        self._validator = SampleValidator(safety, point)
        self._choice = AgeLimitChoice(safety)
        self._hand_link = HandLinkMeter()
        self.latest: Accepted | None = None

    @property
    def age_limit(self) -> AgeLimit:
        """The age limit in force, with what the newest samples show of the link."""
        return self._choice.limit

    @property
    def clock(self) -> ClockSync | None:
        """The newest offset of the clocks that a sample carried."""
        return self._validator.clock

    @property
    def rejected(self) -> Counter[Code]:
        """The numbers of samples that were refused, by code."""
        return self._validator.rejected

    @property
    def network_ms(self) -> float | None:
        """Half a round trip as most of the last seconds' samples show it."""
        return self._hand_link.network_ms

    def figures(self, now_ns: int) -> HandLink | None:
        """Return figures of the way that the last seconds' samples took."""
        return self._hand_link.figures(now_ns)

    def settle(self, pace: float) -> AgeLimit:
        """The age limit until the next tick, for joints at `pace`, a fraction of their greatest speed."""
        return self._choice.settle(pace)

    def receive(self, named: NamedSample, lease: Lease | None, now_ns: int) -> Accepted | Rejected | None:
        """Judge one sample; None for what its holder did not send under the lease in force, which is only counted."""
        operator, sample = named
        held = checked(lease, sample.lease, Holder(sample.session, operator))
        if not isinstance(held, Lease):
            self._validator.refuse(held)
            return None
        stated = clock_offset(sample.clock, now_ns)
        offset = stated if isinstance(stated, ClockOffset) else None
        self._hand_link.arrive(sample, offset, now_ns)
        if offset is not None:
            self._choice.see(sample, now_ns - offset.age_ns(sample.capture_ns, now_ns), now_ns)
        result = self._validator.accept(sample, self.age_limit.soft_ns, now_ns)
        if isinstance(result, Accepted):
            self.latest = result
        return result
