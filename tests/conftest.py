"""Shared by all tests. Standing here also puts tests/ on the path, so that `reference` can be imported."""
