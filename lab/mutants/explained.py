"""Mutants that no test notices, and why none could."""

GUARD = "remote_site/safety/guard.py"
CLEARANCE = "remote_site/safety/clearance.py"
QUICKER = "a shortcut: what it decides is decided the same without it, only later"
STRICT = "all of the sequences have as many entries, so strict never acts"
AT_THE_BOUND = "exactly at the bound, to the last bit, it may count as either"
TARGET = "remote_site/teleop/tool_target.py"
INVERSE, ASSIST = "remote_site/kinematics/inverse.py", "remote_site/assist"
TRACKER, PREDICTOR = "remote_site/motion/target_tracker.py", "remote_site/motion/target_predictor.py"
FAR = (
    "(fastest ** 2 / limits.acceleration + fastest * limits.acceleration / limits.jerk)"  # of a joint, from its limits
)
NEARLY = "abs(t - t_ns) < width * NS_PER_S"

EXPLAINED = {
    f"{GUARD}:spans: True -> False": "both sequences have a joint's entry each, so strict never acts",
    f"{GUARD}:_position: if lower + reach <= middle <= upper - reach: -> if False:": QUICKER,
    f"{CLEARANCE}:clear: HALF_TRAVEL if end == duration else 0.5 -> 0.5": "where a part is halved decides how many are "
    "looked at, not what is found",
    f"{CLEARANCE}:clear: 0.5 -> 1.5": "the first half then reaches beyond the end: more is checked, never less",
    "remote_site/safety/stopping.py:span: 2 -> 3": "of the greatest speed: a bound that is nearer, and still one up to "
    "the greatest acceleration",
    "remote_site/safety/stop_bound.py:_cure: fraction < speed -> fraction <= speed": "at the speed itself, which has "
    "just been refused",
    "remote_site/safety/collision.py:_gradient: length < MIN_NORMAL -> length <= MIN_NORMAL": "a normal of exactly "
    "1e-9, to the last bit, may count as either",
    "remote_site/safety/collision_avoidance.py:_beside: True -> False": STRICT,
    "remote_site/safety/workspace_box.py:_extents: True -> False": STRICT,
    "remote_site/motion/jerk_limited.py:_failure: self._ruckig.reset() -> pass": "Ruckig goes on with a plan whose "
    "motion is what it said last: the same as planned anew",
    "remote_site/motion/jerk_limited.py:_axes: True -> False": STRICT,
    "remote_site/motion/jerk_limited.py:_plan_from: True -> False": STRICT,
    f"{PREDICTOR}:effort: True -> False": STRICT,
    f"{TARGET}:_reaches: True -> False": STRICT,
    f"{TARGET}:_reaches: way <= max(before, limit) + EXACT -> way < max(before, limit) + EXACT": "a "
    "way of exactly a nanometre more, to the last bit, may count as either",
    "remote_site/motion/planner.py:__init__: 1.0 -> 2.0": "whoever follows resets first, which sets it",
    "remote_site/motion/planner.py:__init__: False -> True": "whoever follows resets first, which sets it",
    "remote_site/motion/estimator.py:__init__: self.reset(0, []) -> pass": "whoever aims resets first, which sets it",
    "common/mapping/rotation_mapping.py:__init__: 3 -> 4": "all are free, so that it is not looked at which",
    "remote_site/motion/catch_up.py:update_slow_part: True -> False": STRICT,
    "remote_site/motion/catch_up.py:remaining: 0 -> 1": "in a nanosecond nothing decays",
    f"{PREDICTOR}:_converging: 0 -> 1": "in a nanosecond nothing decays",
    f"{PREDICTOR}:__init__: True -> False": STRICT,
    f"{PREDICTOR}:__init__: {FAR} / 2 -> {FAR} * 2": QUICKER,
    f"{PREDICTOR}:convergence: away > NOTHING -> away >= NOTHING": AT_THE_BOUND,
    "remote_site/motion/tool_shift.py:stretch: det > NOTHING ** 2 -> det >= NOTHING ** 2": AT_THE_BOUND,
    "remote_site/motion/delayed_target.py:_near: self.pace >= RESTS -> self.pace > RESTS": AT_THE_BOUND,
    "remote_site/motion/delayed_target.py:_near: 1.0 -> 2.0": "a target given up on is at the hand's own pace anyway",
    f"remote_site/motion/target_path.py:_averaged: {NEARLY} -> {NEARLY.replace('<', '<=')}": "a sample at the width "
    "itself weighs nothing",
    "remote_site/motion/waiting_target.py:reset: 1 -> 2": "nothing is added while the rate is 0",
    f"{TRACKER}:__init__: self._solved_ns = 0 -> pass": "whoever aims resets first, which sets it",
    f"{TRACKER}:__init__: 0 -> 1": "whoever aims resets first, which sets it",
    f"{TRACKER}:__init__: 6 -> 7": "whoever solves resets it first, which sets it",
    "remote_site/kinematics/dexterity.py:condition: 0 -> 1": "the vectors are computed as well; the values stay",
    f"{INVERSE}:__init__: True -> False": STRICT,
    f"{INVERSE}:_damped_fraction: bend >= WRIST_ZONE -> bend > WRIST_ZONE": "a wrist bent by exactly 0.35, to the last "
    "bit, may count as either",
    f"{INVERSE}:_roll: bend < WRIST_ZONE -> bend <= WRIST_ZONE": "a wrist bent by exactly 0.35, to the last bit, may "
    "count as either",
    f"{INVERSE}:_out_of_reach: distance >= self._least -> distance > self._least": "a wrist at exactly the least "
    "distance, to the last bit, may be told either reason",
    f"{INVERSE}:_roll: here + turn -> here - turn": "joint 4 counts as not there, and the arm makes up for nothing",
    f"{INVERSE}:verify: 2.0 -> 3.0": "other postures: all eight solutions of each are compared, all over the range",
    "remote_site/kinematics/upright_arm.py:joints: True -> False": STRICT,
    f"{ASSIST}/assist.py:__init__: self._ended_ns = 0 -> pass": "it is read once a lead has ended, which sets it",
    f"{ASSIST}/assist.py:is_stuck: left[1] < NEARER_RAD -> left[1] <= NEARER_RAD": "exactly half a degree, to the "
    "last bit, may count as either",
    f"{ASSIST}/standing_marker.py:_moved_by: angle_rad <= MOVED_RAD -> angle_rad < MOVED_RAD": "a turn of exactly "
    "3 deg, to the last bit, may count as either",
    "remote_site/session/engagement_intent.py:expires: now_ns >= self._armed_until_ns -> "
    "now_ns > self._armed_until_ns": "its last nanosecond may count as either",
    "remote_site/session/hand_link_meter.py:__init__: self._newest_ns = -1 -> pass": "the first sample is of another "
    "session than none, which sets it",
    "remote_site/session/link_ages.py:__init__: 0 -> 1": "ages are kept from the second sample on, which sets it",
    "remote_site/session/link_ages.py:usual_ns: True -> False": STRICT,
    "remote_site/session/operator_page.py:_settle: newest.born_ns - first.born_ns >= CALM_NS -> "
    "newest.born_ns - first.born_ns > CALM_NS": "a hand that was calm for exactly 200 ms may count as either",
    "remote_site/teleop/sample_validator.py:__init__: 0 -> 1": "jumps are counted from an accepted sample on, which "
    "sets it",
    "remote_site/teleop/sample_validator.py:_speed_rad_s: 1 -> 2": "of two samples a nanosecond apart, half the speed "
    "is too fast as well",
    "remote_site/teleop/certainty.py:elbow_is_certain: _sigma_mm(covariance, point) <= config.position_poor_mm -> "
    "_sigma_mm(covariance, point) < config.position_poor_mm": "exactly that uncertain, to the last bit, it may count "
    "as either",
    "remote_site/teleop/followed_orientation.py:hand_R_followed: NO_LAG if self._followed is self._shown else "
    "self._shown.T @ self._followed -> self._shown.T @ self._followed": QUICKER,
    "remote_site/session/lease.py:__init__: 0 -> 1": "nobody has asked yet, and who asks sets it",
    "remote_site/drivers/supervisor/write_scheduler.py:reach: 0 -> 1": "a nanosecond of the plan moves no joint",
    "remote_site/drivers/supervisor/writer.py:hand_over: 0 -> 1": "two nanoseconds of the plan move no joint",
    "remote_site/drivers/supervisor/writer.py:hand_over: max(self.plan_ns, self.written_ns) -> "
    "min(self.plan_ns, self.written_ns)": "the same stop at other instants: what the robot has passed is not added",
    "remote_site/drivers/supervisor/reading_check.py:bounds: 0 -> 1": "a nanosecond moves no joint",
    "remote_site/drivers/position_arm/threaded_calls.py:_stuck: self._clock.now_ns() - call[1] > STUCK_NS -> "
    "self._clock.now_ns() - call[1] >= STUCK_NS": "a call of exactly 100 ms, to the nanosecond, may count as either",
    "remote_site/drivers/position_arm/threaded_calls.py:_idle_s: 0 -> 1": "it then waits for a nanosecond",
    "remote_site/drivers/position_arm/arm_stop.py:ended: now_ns - self._last_ns > self._longest_ns -> "
    "now_ns - self._last_ns >= self._longest_ns": "a pause of exactly the longest time may count as either",
    "remote_site/safety/stopping.py:span: 0.0 -> 1.0": "a bound that is wider, and still one",
    "common/mapping/rotation_mapping.py:_update: if self._scale == 1.0: -> if False:": "a shortcut: at a scale of 1 "
    "both ways give the same turn, up to rounding",
    "remote_site/teleop/turn_certainty.py:rotation_covariance: True -> False": "both sequences have three entries, so "
    "strict never acts",
    "remote_site/teleop/followed_orientation.py:_turned: if np.isinf(most).all(): -> if False:": QUICKER,
    "remote_site/teleop/followed_orientation.py:_take_back: t_ns <= born_ns - TAKEN_BACK_NS -> "
    "t_ns < born_ns - TAKEN_BACK_NS": "an orientation of exactly 150 ms before, to the nanosecond, may count as either",
    f"{TARGET}:_elapsed_s: 0 -> 1": "no target is aimed before the first capture, and a nanosecond would not move it",
    "remote_site/teleop/sample_validator.py:__init__: self._jumps = 0 -> pass": "jumps are counted from an accepted "
    "sample on, which sets it",
    f"{TARGET}:_strayed: fraction * way > MOST_M -> fraction * way >= MOST_M": "a way of "
    "exactly 30 mm, to the last bit, may count as either",
    "remote_site/safety/guard.py:same: np.abs(one.q - other.q).max() <= POSITION -> "
    "np.abs(one.q - other.q).max() < POSITION": "positions off by exactly the rounding, to the last bit, may count as "
    "either",
    "remote_site/safety/clearance.py:why: worst[0] < -POSITION -> worst[0] <= -POSITION": "a depth of exactly the "
    "rounding, to the last bit, may be told either reason",
    "remote_site/safety/clearance.py:_doubtful: travel <= TOLERANCE -> travel < TOLERANCE": "a travel of exactly the "
    "tolerance, to the last bit, is looked at once more",
    "remote_site/safety/collision.py:note: 0.0 -> 1.0": "less is known of what stays clear, and it is measured instead",
    "remote_site/safety/collision.py:pairs_within: cache.note(q.tolist(), clearances) -> pass": "nothing is known of "
    "what stays clear, and it is measured instead",
    "remote_site/safety/collision.py:__init__: 1 -> 2": "NumPy takes any negative size for the one that it works out",
    "remote_site/drivers/supervisor/write_scheduler.py:take_part: 0 -> 1": "a nanosecond of the plan moves no joint",
    "remote_site/drivers/supervisor/reading_check.py:_short: abs(value) < 1e+100 -> abs(value) <= 1e+100": "of exactly "
    "that value, all digits are told",
    "remote_site/drivers/position_arm/calls.py:__init__: 0.0 -> 1.0": "the gripper's largest force is told with each "
    "activation, before its first order",
    "remote_site/drivers/position_arm/calls.py:measure: now_ns - self._due_ns -> now_ns + self._due_ns": "it is always "
    "due at a whole period, so that both leave the same rest",
    "remote_site/drivers/franka/setpoint_filter.py:__init__: 0 -> 1": "a nanosecond before the first setpoint changes "
    "no jerk",
}
