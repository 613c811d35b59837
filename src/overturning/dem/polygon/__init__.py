"""The distinct element method for scenes of any convex polygons."""
