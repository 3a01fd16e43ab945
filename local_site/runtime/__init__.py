"""The local site as a process: wiring, figures, warm-up."""
