"""Publishes a hand from one's own code, out of a file of poses.

python examples/published_hand.py POSES.csv [REMOTE] [CELL] [OPERATOR]

Each line of the file is `seconds,x,y,z`: the wrist in m in the operator frame. The arm follows once it is engaged, as
by `farhand engage --operator OPERATOR`; the tool keeps its orientation, since no thumb is known.
"""

import secrets
import sys

import numpy as np

from common.clock import NS_PER_S
from common.host_clock import MonotonicClock
from common.link.channels import HAND
from common.link.transport import open_link
from common.messages.base import SESSION_BITS
from common.messages.hand import TrackingStatus
from local_site.authority.lease_client import Authority
from local_site.samples.hand_sample import HandSampler, OpenHand
from local_site.tracking.tracker import ArmEstimate

PERIOD_NS = NS_PER_S // 60
SURE = {"wrist": 0.001**2 * np.eye(3)}  # m², the arm is slower where the hand is less sure


def main(file: str, remote: str = "tcp/127.0.0.1:7447", cell: str = "lab", operator: str = "example") -> None:
    """Lead the hand along the poses, once, as a local site would."""
    seconds, *wrist = np.loadtxt(file, delimiter=",", ndmin=2).T
    clock, session = MonotonicClock(), secrets.randbits(SESSION_BITS)
    sampler, start_ns = HandSampler(session), clock.now_ns()
    with open_link(connect=(remote,)) as link, Authority(link, cell, operator, session, automatic=True) as authority:
        publisher = link.publisher(HAND, cell, operator=operator)
        for number in range(1, int(seconds[-1] * 60) + 1):
            clock.sleep_until_ns(start_ns + number * PERIOD_NS)
            now_ns = clock.now_ns()
            place = np.array([np.interp((now_ns - start_ns) / NS_PER_S, seconds, axis) for axis in wrist])
            estimate = ArmEstimate(now_ns, TrackingStatus.TRACKED, "", wrist=place, covariances=SURE)
            held = authority.lease_and_clock(now_ns, now_ns)
            publisher.put(sampler.sample(estimate, OpenHand(), held.lease, held.clock, None, now_ns))


if __name__ == "__main__":
    main(*sys.argv[1:])
