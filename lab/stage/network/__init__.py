"""Two hosts on this machine, and the link between them: namespaces, and a shim that delays, loses and limits."""
