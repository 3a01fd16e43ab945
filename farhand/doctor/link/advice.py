"""Judges a measured link and recommends the settings for it, as findings with their TOML keys; pure."""

import math
from collections.abc import Sequence

from common.clock import NS_PER_MS
from farhand.doctor.findings import Finding, error, ok, warning
from farhand.doctor.link.figures import LinkFigures, WayFigures
from remote_site.safety.config import FULL_SPEED_MS
from remote_site.session.age_limit import MOST_NS, SPARE_NS, STEP_NS

SAMPLE_MS = 33.0  # between hand samples, and
TRACKING_MS = 40.0  # from capture to sending, unless the cell has measured both
LEAST_LIMIT_MS, MOST_LIMIT_MS = FULL_SPEED_MS, MOST_NS / NS_PER_MS
STEP_MS, SPARE_MS = STEP_NS / NS_PER_MS, SPARE_NS / NS_PER_MS
WORTH_MS = 20.0  # younger samples, to change the protocol for
RARE, MOST_LOSS = 0.01, 0.9
LOSSY = 0.005  # from here on samples by TCP wait too often for a lost one
PICTURES_MS = 60.0  # from exposure to painting, without the network
COMFORTABLE_MS, LEAST_SCALE = 250.0, 0.25
JPEG_MBIT_S, H264_MBIT_S = 40.0, 5.0  # four views of 640 x 480 at 30 fps
BULK_SHARE = 0.7  # of what the link carries, for pictures


def judge_links(links: Sequence[LinkFigures], untried: Sequence[Finding], configured: str) -> list[Finding]:
    """A finding for every measured link, then the recommendations for the one in use, at the `configured` endpoint.

    `untried` are the findings about protocols that could not be measured.
    """
    findings = [*map(describe, links), *untried]
    used = next((link for link in links if link.endpoint == configured), None)
    if used is None:
        return findings
    by_tcp = next((link for link in links if link.protocol != "quic"), used)  # pictures never go by QUIC
    return [
        *findings,
        check_protocol(used, links),
        check_age_limit(used),
        check_scale(used),
        check_pictures(by_tcp),
    ]


def describe(link: LinkFigures) -> Finding:
    """Describe what was measured at one endpoint."""
    sentence = (
        f"{link.endpoint}: round trip {link.least_ms:.1f} ms at least, {link.median_ms:.1f} median, {link.p99_ms:.1f} "
        f"p99; there {_way(link.there, link.protocol)}; back {_way(link.back, link.protocol)}"
    )
    check = f"link {link.protocol}"
    if link.engaged:
        sentence += "; measured with little, and without load: the arm is engaged"
    if link.loss >= LOSSY:
        return warning(check, sentence, "look for a full line or poor Wi-Fi on the way")
    return ok(check, sentence)


def check_protocol(used: LinkFigures, links: Sequence[LinkFigures]) -> Finding:
    """TLS or QUIC for the hand: where packets are lost no datagram waits for one before it, but QUIC sends less."""
    best = min(links, key=needed_limit_ms)
    younger_ms = needed_limit_ms(used) - needed_limit_ms(best)
    if younger_ms > WORTH_MS:
        sentence = f"by {best.protocol} hand samples come up to {younger_ms:.0f} ms younger than by {used.protocol}"
        return warning("protocol", sentence, _write_as(best.protocol, used))
    tried = {link.protocol for link in links}
    if used.protocol == "tls" and used.loss >= LOSSY and "quic" not in tried:
        sentence = f"about {used.loss:.1%} of the packets are lost, and by TLS samples wait for those lost before them"
        return warning("protocol", sentence, f"{_write_as('quic', used)}; let UDP through to that port")
    if len(tried) == 1:
        return ok("protocol", f"only {used.protocol} was measured, so that nothing speaks for another")
    return ok("protocol", f"{used.protocol} serves the hand as well as {' and '.join(sorted(tried))} would")


def needed_limit_ms(link: LinkFigures) -> float:
    """The age of a hand sample just before the next comes: tracking, one way, the clocks' uncertainty, the interval.

    One way is half of the quickest round trip and what 1 % of the probes exceed; the uncertainty is the other half.
    Each of a run of lost samples adds an interval, for runs of more than one in a hundred.
    """
    hand, loss = link.hand, min(link.there.loss, MOST_LOSS)
    tracking_ms = hand.tracking_ms if hand is not None and hand.tracking_ms is not None else TRACKING_MS
    interval_ms = hand.interval_ms if hand is not None else SAMPLE_MS
    lost_in_a_row = math.floor(math.log(RARE) / math.log(loss)) if loss >= RARE else 0
    return tracking_ms + link.least_ms + link.there.excess_p99_ms + (1 + lost_in_a_row) * interval_ms


def check_age_limit(link: LinkFigures) -> Finding:
    """Judge whether the link can be operated at all, with the age limit that suits it."""
    needed_ms = needed_limit_ms(link)
    sentence = f"hand samples will be up to {needed_ms:.0f} ms old"
    if needed_ms > MOST_LIMIT_MS:
        return error(
            "age limit",
            f"{sentence}; at most {MOST_LIMIT_MS:.0f} ms can be operated: the arm will not engage, or always hold",
            "a quicker way: cable instead of Wi-Fi, no VPN, a nearer router",
        )
    limit_ms = min(max(LEAST_LIMIT_MS, -(-(needed_ms + SPARE_MS) // STEP_MS) * STEP_MS), MOST_LIMIT_MS)
    speed = min(1.0, LEAST_LIMIT_MS / limit_ms)
    chosen = f'safety.t_soft_ms = "auto" will choose about {limit_ms:.0f} ms, at {speed:.0%} of full speed'
    return ok("age limit", f"{sentence}; at the remote site {chosen}")


def check_scale(link: LinkFigures) -> Finding:
    """The scale that suits the delay from the hand to the eye."""
    delay_ms = TRACKING_MS + SAMPLE_MS + link.median_ms + PICTURES_MS
    scale = max(LEAST_SCALE, min(1.0, round(20 * COMFORTABLE_MS / delay_ms) / 20))
    sentence = f"from the hand to the eye it takes about {delay_ms:.0f} ms"
    if scale == 1.0:
        return ok("scale", f"{sentence}: no smaller scale is needed")
    return ok(
        "scale", f"{sentence}: begin with a scale of {scale:g} (on the page, or mapping.scale at the remote site)"
    )


def check_pictures(link: LinkFigures) -> Finding:
    """Which pictures the way back carries."""
    carried = link.back.mbit_s
    if carried is None:
        cure = "disengage, and measure again"
        return warning("pictures", "what the link carries was not measured: the arm is engaged", cure)
    share = BULK_SHARE * carried
    sentence = f"the way back carries {carried:.1f} Mbit/s"
    if share >= JPEG_MBIT_S:
        return ok("pictures", f'{sentence}: four views as JPEG at 30 fps (video.codec = "auto" keeps them)')
    if carried >= H264_MBIT_S:
        return ok(
            "pictures",
            f"{sentence}, of which pictures use {BULK_SHARE:.0%}; four views as JPEG need about {JPEG_MBIT_S:.0f}: "
            'video.codec = "auto" sends them as H.264',
        )
    cure = "fewer views or pictures at the remote site: video.cameras, video.fps = 15; or a wider line"
    return warning("pictures", f"{sentence}, and four views as H.264 need about {H264_MBIT_S:.0f}", cure)


def _way(way: WayFigures, protocol: str) -> str:
    loss = f"loss {way.loss:.1%}"
    if protocol != "quic" and way.stalls:
        loss = f"loss hidden by TCP, by its stalls about {way.stalls:.1%}"
    rate = "" if way.mbit_s is None else f", carries {way.mbit_s:.1f} Mbit/s"
    return f"jitter {way.jitter_ms:.1f} ms, {loss}{rate}"


def _write_as(protocol: str, used: LinkFigures) -> str:
    """The cure: the endpoint by another protocol, at both sites."""
    address = used.endpoint.partition("/")[2]
    return (
        f'links.control = "{protocol}/..." at the remote site, and here links.remote (of a console links.control) = '
        f'"{protocol}/{address}"'
    )
