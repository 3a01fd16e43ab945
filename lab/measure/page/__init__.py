"""The operator's page, measured in a browser."""
