"""What both sites must agree on: messages, time, geometry, transport, configuration, a daemon's life."""
