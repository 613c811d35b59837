"""Rotation, intensity measures, spectra and pulses."""
