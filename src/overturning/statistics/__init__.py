"""Statistics of cubes: functions of the falls that a model gives, so that none asks what stood on the ground.

A new one begins from `falls.fall_vectors` or `model_of(cube).falls(cube)`; what stands over earthquakes, with its
interval, from `bootstrap.mean_over_earthquakes`; cubes larger than memory are read by `by_record`.
"""
