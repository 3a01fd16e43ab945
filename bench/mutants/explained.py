"""Mutants that no test notices, and why none could."""

GUARD = "remote_site/safety/guard.py"
CLEARANCE = "remote_site/safety/clearance.py"
QUICKER = "a shortcut: what it decides is decided the same without it, only later"

EXPLAINED = {
    f"{GUARD}:spans: True -> False": "both sequences have a joint's entry each, so strict never acts",
    f"{GUARD}:_position: if lower + reach <= middle <= upper - reach: -> if False:": QUICKER,
    f"{CLEARANCE}:clear: HALF_TRAVEL if end == duration else 0.5 -> 0.5": "where a part is halved decides how many are "
    "looked at, not what is found",
    f"{CLEARANCE}:clear: 0.5 -> 1.5": "the first half then reaches beyond the end: more is checked, never less",
    "remote_site/session/lease.py:__init__: 0 -> 1": "nobody has asked yet, and who asks sets it",
    "remote_site/drivers/supervisor/write_scheduler.py:reach: 0 -> 1": "a nanosecond of the plan moves no joint",
    "remote_site/drivers/supervisor/writer.py:hand_over: 0 -> 1": "two nanoseconds of the plan move no joint",
    "remote_site/drivers/supervisor/writer.py:hand_over: max(self.plan_ns, self.written_ns) -> "
    "min(self.plan_ns, self.written_ns)": "the same stop at other instants: what the robot has passed is not added",
    "remote_site/drivers/supervisor/plausible_motion.py:bounds: 0 -> 1": "a nanosecond moves no joint",
    "remote_site/drivers/position_arm/threaded_calls.py:_stuck: self._clock.now_ns() - call[1] > STUCK_NS -> "
    "self._clock.now_ns() - call[1] >= STUCK_NS": "a call of exactly 100 ms, to the nanosecond, may count as either",
    "remote_site/drivers/position_arm/threaded_calls.py:_idle_s: 0 -> 1": "it then waits for a nanosecond",
    "remote_site/drivers/position_arm/written_stop.py:ended: now_ns - self._last_ns > self._longest_ns -> "
    "now_ns - self._last_ns >= self._longest_ns": "a pause of exactly the longest time may count as either",
    "remote_site/safety/stopping.py:span: 0.0 -> 1.0": "a bound that is wider, and still one",
    "common/mapping/rotation_mapping.py:_update: if self._scale == 1.0: -> if False:": "a shortcut: at a scale of 1 "
    "both ways give the same turn, up to rounding",
    "remote_site/teleop/turn_certainty.py:rotation_covariance: True -> False": "both sequences have three entries, so "
    "strict never acts",
    "remote_site/teleop/followed_orientation.py:_turned: if np.isinf(most).all(): -> if False:": QUICKER,
    "remote_site/teleop/followed_orientation.py:_take_back: t_ns <= born_ns - TAKEN_BACK_NS -> "
    "t_ns < born_ns - TAKEN_BACK_NS": "an orientation of exactly 150 ms before, to the nanosecond, may count as either",
    "remote_site/teleop/tool_target.py:_elapsed_s: 0 -> 1": "no target is aimed before the first capture, and a "
    "nanosecond would not move it",
    "remote_site/teleop/sample_validator.py:__init__: self._jumps = 0 -> pass": "jumps are counted from an accepted "
    "sample on, which sets it",
    "remote_site/teleop/tool_target.py:_strayed: fraction * way > MOST_M -> fraction * way >= MOST_M": "a way of "
    "exactly 30 mm, to the last bit, may count as either",
}
