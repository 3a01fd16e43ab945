"""The four views through narrow links."""
