"""The rooms behind the arm, and how cameras see them."""
