"""Recordings of an hour: how soon they open, how soon another time of them is shown, and their repair."""
