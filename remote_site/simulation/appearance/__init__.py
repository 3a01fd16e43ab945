"""What the simulated cell looks like: textures, prints, furniture, and light baked into all that stands still."""
