"""Tracking of recordings."""
