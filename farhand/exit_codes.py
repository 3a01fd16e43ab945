"""The command line's exit codes; 0 is done."""

FAILED, MISUSE, UNDECIDED, INTERRUPTED = 1, 2, 3, 130  # undecided: nothing failed, and not all could be judged
