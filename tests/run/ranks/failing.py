"""`neve run` over ranks, one of which fails in the words of `NEVE_FAILS` after some sorts."""

import os

import numpy as np

from neve.cli import main
from neve.ranks import launch
from neve.ranks.domain import Domain

SORTS = 3
FAILS = os.environ["NEVE_FAILS"]


def find_owners(self, model, state):
    """Lose a particle of the last rank."""
    self.sorts = getattr(self, "sorts", 0) + 1
    if FAILS == "lost" and is_time(self):
        np.asarray(state.x)[0] = 1e6
    usual_owners(self, model, state)


def migrate(self, state, grid):
    """Fail on the last rank."""
    if FAILS == "fault" and is_time(self):
        raise ValueError("injected")
    usual_migration(self, state, grid)


def is_time(domain):
    """Tell whether this is the last rank, and has sorted often enough."""
    return domain.sorts == SORTS and launch.rank() == launch.size() - 1


usual_owners, Domain.find_owners = Domain.find_owners, find_owners
usual_migration, Domain.migrate = Domain.migrate, migrate
main()
