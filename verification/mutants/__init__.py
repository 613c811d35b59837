"""Mutants: faults of one token put into the sources, which the tests have to notice."""
