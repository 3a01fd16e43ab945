"""The eye's training: arms drawn by program, networks that learn to see them, and what they are worth."""
