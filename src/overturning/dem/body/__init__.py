"""Kernel of a single convex 3-D body, moved by all components of the motion; contact at its vertices or its rim."""
