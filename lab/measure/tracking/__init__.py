"""The trackers' time and error."""
