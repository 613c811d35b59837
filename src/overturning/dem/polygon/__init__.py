"""Kernel of 2-D scenes: elements of one or several convex polygons."""
