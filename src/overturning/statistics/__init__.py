"""Statistics of cubes, for every model.

A new statistic starts from `falls.fall_vectors` or `model_of(cube).falls(cube)`. Means over earthquakes with intervals
come from `bootstrap.mean_over_earthquakes`. `by_record` reads cubes larger than memory.
"""
