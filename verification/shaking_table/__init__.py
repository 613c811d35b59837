"""Predictions beside 490 shaking-table tests of a granite boulder: who says best which tests it falls in."""
