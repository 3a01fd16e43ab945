"""The experiments of the report "Teleoperating ROBONAUT" (UH-CS-02-01, 2002)."""
