"""The shapes of links: meshes read, covered by capsules, weighed."""
