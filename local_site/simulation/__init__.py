"""The simulated operator: a bare arm before two cameras, with exact truth."""
