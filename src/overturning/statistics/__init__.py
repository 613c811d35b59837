"""Statistics of cubes, computed from the falls that a model returns, so that no function depends on the model.

A new statistic starts from `falls.sum_fall_vectors_over_directions` or
`default_model_of_same_kind_as_results_cube(cube).fall_probability_and_direction_by_case(cube)`. Use
`bootstrap.mean_over_earthquakes` for means over earthquakes with their intervals, and `by_record` for cubes that are
larger than memory.
"""
