"""Faults of every kind put to a small study: it must go on by the same command, to the same cube."""
