"""Infrastructure of all kernels: lanes, step control, case queue, base motion, termination, and compilation."""
