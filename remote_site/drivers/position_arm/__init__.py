"""Three methods of an arm that takes positions, made a whole driver."""
