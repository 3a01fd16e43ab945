"""A driver of Farhand for the arm new_arm."""
