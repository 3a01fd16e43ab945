"""The remote site as processes: control, reports, the driver's process, start and end."""
