"""Whether the pair of sites grows while it runs: memory, descriptors and threads of every process over an hour."""
