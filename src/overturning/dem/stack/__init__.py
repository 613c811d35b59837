"""Stacks of stones in 3-D: the kernel of the model `overturning.model.stack.Stack`."""
