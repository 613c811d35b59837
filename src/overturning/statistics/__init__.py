"""Direction statistics, overturning boundaries, survey comparison."""
