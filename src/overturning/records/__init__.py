"""Strong-motion records: formats in, one Record out."""
