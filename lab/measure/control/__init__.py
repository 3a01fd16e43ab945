"""The cost of a control tick."""
