"""One block on a moving base: the fast kernel."""
