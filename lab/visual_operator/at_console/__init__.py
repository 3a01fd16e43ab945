"""The visual operator in real time, as a process of its own: before a console's page, and moving the filmed hand."""
