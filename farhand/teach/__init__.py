"""A task that was done by hand once, as way points that are edited by hand and run again."""
