"""Recordings of either site as MCAP files: written, split, bounded, ended by a full disk, repaired, and read."""
