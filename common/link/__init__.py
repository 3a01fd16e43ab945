"""The link between sites: the table of channels, sessions, certificates, access."""
