"""What the console knows and decides, without I/O or a clock: latencies, history, the seat, frames for pages."""
