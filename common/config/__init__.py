"""Configurations: TOML and --set to a checked struct, the keys of earlier releases, a wrong type in plain words."""
