"""Session: when the arm may follow, and whom; state machine, lease, faults; pure."""
