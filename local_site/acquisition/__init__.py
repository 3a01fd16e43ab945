"""The rig's cameras: opened, read, paired to common instants."""
