"""The operator's page: what the cell shows and says, and the operator's intent and brakes."""
