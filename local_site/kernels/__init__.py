"""Inner loops compiled to machine code."""
