"""What both sites have in common: messages, time, geometry, links, configuration, a daemon's lifecycle."""
