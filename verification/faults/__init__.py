"""Faults of every kind during a small study: the same command must resume it and give the same cube."""
