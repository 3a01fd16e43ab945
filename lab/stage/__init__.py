"""Emulated hosts, links, operators and cameras, between which both sites are measured."""
