"""Field surveys of fallen stones: comparison with the prediction of a cube, and inversion for the motion."""
