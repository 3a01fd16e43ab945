"""Certificates for the links: a private certificate authority, and what it issues for each role at a cell."""
