"""What stands on the ground: its symmetry, and over which edge it falls."""
