"""Checks a machine and a configuration, and says what to do: facts are probed, findings are made of facts."""
