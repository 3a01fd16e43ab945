"""`farhand replay --to-robot` against a real remote site: nothing without hold-to-run, the recorded path with it."""
