"""The command line, `neve`: its commands, what they share, and what to cite."""

from neve.cli.commands import cli as cli
from neve.cli.commands import main as main
