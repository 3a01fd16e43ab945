"""The rooms behind the arm."""
