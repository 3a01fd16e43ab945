"""State and decisions of the console, without I/O or a clock: latencies, history, the seat, frames for pages."""
