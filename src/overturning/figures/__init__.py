"""Figures, from xarray to Matplotlib axes."""
