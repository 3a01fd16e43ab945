"""`python -m bench`: the measurements of Farhand's laboratory, from a checkout."""

import sys

from lab.measure.command import main

if __name__ == "__main__":
    main(sys.argv[1:])
