"""The command line's exit codes, of every command alike; 0 is done.

FAILED: it was begun and failed, or what was examined is not right. MISUSE: the options or the configuration were
refused before anything began. UNDECIDED: nothing failed, and not all could be judged. docs/operating.md says the same.
"""

FAILED, MISUSE, UNDECIDED, INTERRUPTED = 1, 2, 3, 130
