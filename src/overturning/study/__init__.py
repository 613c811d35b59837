"""Configuration, case grid, sweep, cube."""
