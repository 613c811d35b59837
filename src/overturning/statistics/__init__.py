"""Direction statistics and overturning boundaries."""
