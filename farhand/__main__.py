"""`python -m farhand`: the command line."""

from farhand.cli import main

main()
