"""Recorded sessions as tables: CSV, a row an instant."""
