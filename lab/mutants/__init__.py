"""Small changes to the code that decides about motion: each must make a test fail."""
