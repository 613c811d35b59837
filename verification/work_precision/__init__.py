"""Error against run time: of schemes, time steps and stiffnesses, and of other engines."""
