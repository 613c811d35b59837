"""What people found in the field: reading surveys of fallen stones, what the cube predicts for them, and how both agree."""
