"""The operator's page: the cell's views and state, and the operator's intent and stop."""
