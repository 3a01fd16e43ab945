"""The joints' motion between hand samples: target prediction, tracking, jerk-limited motion; pure."""
