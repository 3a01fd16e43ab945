"""Whether a busy machine has ended an engagement: no configuration waits more than a second for a hand sample."""

LATE = ("newest hand sample is", "hand samples came late", "control paused for")


def was_late(reason: str) -> bool:
    """Whether this is the reason of an engagement that ended because samples or control came too late."""
    return reason.startswith("disengaged, ") and any(words in reason for words in LATE)
