"""Files that an import writes: the arm's URDF, the configuration, the summary."""
