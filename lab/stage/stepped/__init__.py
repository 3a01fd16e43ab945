"""The remote site on stepped time, without a process: around the simulated cell, the emulated controller or any arm."""
