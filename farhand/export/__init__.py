"""What a recorded session becomes for others: a LeRobot dataset, tables, videos."""
