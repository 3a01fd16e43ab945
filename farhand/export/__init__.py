"""Export of a recorded session for others: a LeRobot dataset, tables, videos."""
