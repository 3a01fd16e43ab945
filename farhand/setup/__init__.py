"""Setting up the operator's side: from cameras that are plugged in to a configuration that works."""
