"""Growth of the pair of sites while it runs: memory, descriptors and threads of every process over an hour."""
