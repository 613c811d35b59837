"""Which way gravestones fall in an earthquake, and how sure one can be."""
