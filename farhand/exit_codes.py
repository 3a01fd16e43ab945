"""What the command line's exit codes say, beside 0 for done."""

FAILED, MISUSE, INTERRUPTED = 1, 2, 130
