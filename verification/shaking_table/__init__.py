"""Predictions for 490 shaking-table tests of a granite boulder, by several models."""
