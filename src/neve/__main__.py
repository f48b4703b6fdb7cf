"""`python -m neve`: the command line, for who has several Pythons."""

from neve.cli import main

main()
