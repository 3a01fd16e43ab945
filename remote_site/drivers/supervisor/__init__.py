"""Between commands and every driver: limits, time-out, verified stop."""
