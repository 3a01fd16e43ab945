"""`farhand driver new`: the package of a new driver, which works from the start on a simulated arm."""
