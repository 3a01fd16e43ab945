"""A hand that leads the tool along a given path, as a recording or a taught task has it, instead of the operator's."""
