"""What people found in the field: surveys of fallen stones, what the cube predicts for them, and how both agree."""
