"""Emulated hosts, links, operators and cameras, between which sites are measured; and a site on stepped time."""
