"""The wire messages, the requests, and how they become bytes."""
