"""Takes the hand samples from the wire: only the lease holder's count, judged one by one, their way measured; pure."""

from collections import Counter

from common.clock import ClockOffset
from common.messages.hand import ClockSync
from common.messages.robot import HandLink
from remote_site.reasons import Code
from remote_site.session.age_limit import AgeLimit
from remote_site.session.hand_link_meter import HandLinkMeter
from remote_site.session.lease import Holder, Lease, checked
from remote_site.session.samples import Accepted, NamedSample, Rejected
from remote_site.session.state_machine import Session
from remote_site.teleop.config import PipelineConfig
from remote_site.teleop.sample_validator import SampleValidator, clock_offset


class SampleReceiver:
    """`latest` is the newest sample that may be followed."""

    def __init__(self, config: PipelineConfig, session: Session, age_limit: AgeLimit) -> None:
        self._session = session
        self._validator = SampleValidator(config.safety, age_limit, config.mapping.point)
        self._hand_link = HandLinkMeter()
        self.latest: Accepted | None = None

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

    def receive(self, named: NamedSample, lease: Lease | None, now_ns: int) -> Accepted | Rejected:
        """Judge one sample; what its holder did not send under the lease in force is only counted."""
        operator, sample = named
        held = checked(lease, sample.lease, Holder(sample.session, operator))
        if not isinstance(held, Lease):
            return self._validator.refuse(held)
        self._session.authorise(held)
        offset = clock_offset(sample.clock, now_ns)
        self._hand_link.arrive(sample, offset if isinstance(offset, ClockOffset) else None, now_ns)
        result = self._validator.accept(sample, now_ns)
        self._session.sample(result)
        if isinstance(result, Accepted):
            self.latest = result
        return result
