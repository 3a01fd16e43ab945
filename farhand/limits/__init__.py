"""What `farhand limits` prints: the limits of a configured arm, where they come from, and its stops."""
