"""Kernel of a single 2-D block on a moving base."""
