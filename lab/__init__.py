"""Farhand's laboratory: measures Farhand and reproduces its sources; a distribution of its own that nothing imports."""
