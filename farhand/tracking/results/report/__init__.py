"""A track's report: the figures of all pairs, their plots, and the pairs that a person should look at."""
