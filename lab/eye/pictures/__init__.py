"""Pictures of drawn arms: skin, cloth and light, rooms and other people, and what a camera makes of it."""
