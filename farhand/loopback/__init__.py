"""Both sites on this machine: configured, started, watched, measured."""
