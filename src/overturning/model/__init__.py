"""Blocks, scenes and bodies: geometry, contacts, symmetry, outcome variables and fall directions."""
