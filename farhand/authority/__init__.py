"""Requests to the sites on behalf of a person at a terminal: engagement, maintenance, the lease."""
