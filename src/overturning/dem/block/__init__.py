"""One rectangular block on its base: the fastest kernel."""
