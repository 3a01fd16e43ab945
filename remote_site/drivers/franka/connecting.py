"""Reasons for no connection to a robot, by what libfranka says: a sentence with the address and its cure; pure."""

import re

from common.errors import DriverError
from remote_site.drivers.franka.robot_port import UnreachableError

SILENT = "the robot at {host} does not answer: check its power, the cable and driver.options.host"
NO_REAL_TIME = (
    "this machine's kernel has no real time, without which the client does not talk to the robot at {host}: run a "
    "PREEMPT_RT kernel, or against a simulator set driver.options.realtime = false"
)
# Words of libfranka 0.21 and its sockets, with what they mean and what cures it.
CAUSES = (
    (r"host not found|no address found", "the address {host} of the robot is not known: correct driver.options.host"),
    (r"refused", "the robot at {host} refuses the connection: activate FCI in its page Desk"),
    (r"time(d )?out|interrupted|host is down", SILENT),
    (r"unreachable|no route", "the robot at {host} is in no network of this machine: check driver.options.host"),
    (
        r"incompatible library version",
        "the robot at {host} speaks another version of its protocol: install the pylibfranka that fits its system",
    ),
)


def connection_error(host: str, said: str) -> DriverError:
    """The error of a connection to `host` that libfranka refused with these words; UnreachableError if it may pass."""
    if "realtime" in said.lower():
        return DriverError(NO_REAL_TIME.format(host=host))
    known = (what for words, what in CAUSES if re.search(words, said, re.IGNORECASE))
    why = said.removeprefix("libfranka: ").rstrip(".")
    unknown = f"the robot at {host} cannot be reached ({why}): see its page Desk"
    return UnreachableError(next(known, "").format(host=host) or unknown)
