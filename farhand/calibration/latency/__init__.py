"""The latency of cameras, measured by a screen that blinks before them."""
