"""Ground motions: rotation, intensity measures, spectra, pulses, soil response."""
