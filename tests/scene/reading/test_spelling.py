"""The nearest known word, and how it is offered."""

import pytest

from neve.spelling import hint, nearest


@pytest.mark.parametrize(
    ("word", "known", "expected"),
    [
        ("vieu", ["run", "view"], "view"),
        ("RADIUS", ["radius", "center"], "radius"),
        ("Box", ["BOX", "ball"], "BOX"),
        ("zzz", ["run", "view"], None),
        ("run", [], None),
    ],
)
def test_nearest_word(word, known, expected):
    """The most similar word is found whatever its case, and none where nothing is similar."""
    assert nearest(word, known) == expected


def test_a_synonym_wins_over_spelling_if_it_is_known():
    """`density` means rho0 where there is a rho0, and is compared by spelling where there is none."""
    assert nearest("density", ["rho0", "densities"], {"density": "rho0"}) == "rho0"
    assert nearest("density", ["densities"], {"density": "rho0"}) == "densities"


def test_hint_offers_the_word_or_something_else_or_nothing():
    """A hint begins with a blank, so that a sentence can end in it."""
    assert hint("view", "the commands are run, view") == " (did you mean view?)"
    assert hint(None, "the commands are run, view") == " (the commands are run, view)"
    assert hint(None) == ""
