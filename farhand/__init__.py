"""The command line, and what puts both sites together."""
