"""Certificates for the links: a certificate authority of one's own, and what it issues for each role at a cell."""
