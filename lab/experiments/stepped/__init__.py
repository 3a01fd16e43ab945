"""The remote site on stepped time, without a process: around the simulated cell or the emulated controller."""
