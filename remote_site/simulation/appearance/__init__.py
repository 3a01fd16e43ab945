"""Looks of the simulated cell: textures, prints, furniture, and light baked into all that stands still."""
