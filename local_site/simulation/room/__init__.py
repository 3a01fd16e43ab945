"""The simulated operator in colour: bare skin in an ordinary room."""
