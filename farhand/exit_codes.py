"""The command line's exit codes; 0 is done."""

FAILED, MISUSE, INTERRUPTED = 1, 2, 130
