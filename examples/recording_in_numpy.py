"""A recording as arrays, at ten instants a second: python examples/recording_in_numpy.py RUN.mcap OUT.npz"""

import sys
from pathlib import Path

import numpy as np

from farhand.export.recording import open_sessions

PERIOD_NS = 100_000_000


def main(recording: str, out: str) -> None:
    """Write times (n,) s, joints measured and sent (n, joints) rad, the tool (n, 7) in m and as a quaternion."""
    with open_sessions([Path(recording)]) as (session,):
        facts, signals = session.facts, session.signals()
        instants = np.arange(facts.begin_ns, facts.end_ns, PERIOD_NS)
        np.savez(
            out,
            t_s=(instants - facts.begin_ns) / 1e9,
            joints=signals.joints.at(instants),
            sent=signals.actions.motion.at(instants),
            tool=signals.tool.at(instants),
            state=np.array(signals.states.at(instants)),
        )
    print(f"{len(instants)} instants of {facts.robot}, joints {', '.join(facts.joint_names)}, in {out}")


if __name__ == "__main__":
    main(*sys.argv[1:])
