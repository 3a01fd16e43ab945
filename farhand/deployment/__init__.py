"""The configurations and systemd units that Farhand ships, and whose configuration a file is."""
