"""The parts that both sites share: messages, time, geometry, links, configuration, a daemon's lifecycle."""
