"""Pure decisions about each camera's stream: status, quality, size and rate."""
