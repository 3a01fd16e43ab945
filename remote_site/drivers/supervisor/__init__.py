"""What stands between commands and every driver: limits, time-out, verified stop; pure."""
