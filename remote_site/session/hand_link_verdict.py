"""Verdict on the way of the hand samples: the greatest part of their age, loss, clocks, with the cure; pure."""

from collections.abc import Mapping

from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.messages.robot import HandLink
from remote_site.reasons import MORE_PICTURES, Code, Reason, reason
from remote_site.session.link_ages import LONGEST_INTERVAL_NS

LOSSY = 0.03  # of the samples of the meter's window
UNSTEADY_MS = 15.0  # of jitter: packets that wait for a lost one before them
MORE_AGE = "or allow more age: safety.t_soft_ms = 'auto'"
QUICKER = f"take a quicker way (cable instead of Wi-Fi, no VPN), relieve a host that is overloaded, {MORE_AGE}"
CURES = {
    "network": f"Cure: {QUICKER}",
    "unsteady network": "Cure: if the control endpoint is tls/, write it as quic/ at both sites, so that no sample "
    f"waits for a lost packet; or {QUICKER}",
    "clocks": f"The clocks are known to half of the quickest round trip only. Cure: {QUICKER}",
    "cameras": MORE_PICTURES,
    "tracking": "Cure: relieve the local site's host, or choose a quicker tracker or smaller pictures there",
    "loss": "Cure: look for a full line or poor Wi-Fi on the way; 'farhand doctor --link' measures it",
}
# Instead of these where both sites' traffic stays on one host: no network is between them, unless a port is forwarded.
ON_ONE_HOST = dict.fromkeys(
    ("network", "unsteady network", "clocks"),
    f"Cure: relieve this machine if it is overloaded (through a tunnel: take a quicker way), {MORE_AGE}",
)


def judged(link: HandLink | None, limit_ms: float, *, one_host: bool = False) -> HandLink | None:
    """The figures with code and reason of what is wrong; `limit_ms` is the age beyond which the arm holds.

    `one_host` is whether the traffic of both sites stays on this host.
    """
    why = _trouble(link, limit_ms, CURES | ON_ONE_HOST if one_host else CURES) if link is not None else None
    return link if link is None or why is None else replace(link, code=why.code.value, reason=why.sentence)


def _trouble(link: HandLink, limit_ms: float, cures: Mapping[str, str]) -> Reason | None:
    if link.age_ms is None:
        return reason(Code.CLOCK_UNKNOWN)
    if link.age_ms + link.interval_ms > limit_ms:
        return _too_old(link, link.age_ms, limit_ms, cures)
    if link.loss >= LOSSY:
        return reason(Code.SAMPLES_LOST, loss=link.loss, cure=CURES["loss"])
    return None


def _too_old(link: HandLink, age_ms: float, limit_ms: float, cures: Mapping[str, str]) -> Reason:
    parts = {"network": link.network_ms or 0.0, "clocks": link.clock_ms or 0.0, "tracking": link.tracking_ms or 0.0}
    # The age limit never grows for rarer samples, so that they are the cause where they outlast all parts of the age.
    rare = {"cameras": link.interval_ms} if link.interval_ms * NS_PER_MS > LONGEST_INTERVAL_NS else {}
    greatest = max(parts | rare, key=lambda part: (parts | rare)[part])
    unsteady = greatest == "network" and link.jitter_ms >= UNSTEADY_MS
    return reason(
        Code.SAMPLES_OLD,
        age_ms=age_ms,
        interval_ms=link.interval_ms,
        limit_ms=limit_ms,
        network_ms=parts["network"],
        clock_ms=parts["clocks"],
        tracking_ms=parts["tracking"],
        cure=cures["unsteady network" if unsteady else greatest],
    )
