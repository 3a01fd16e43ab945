"""Limits of a configured arm, as `farhand limits` prints them: where they come from, and its stops."""
