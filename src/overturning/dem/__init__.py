"""Distinct element method: scenes, contact laws, step control, and compiled kernels."""
