"""Run the command line: `python -m neve.cli`."""

from neve.cli.commands import main

if __name__ == "__main__":
    main()
