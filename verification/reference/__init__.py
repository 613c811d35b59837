"""Solutions of the field that share nothing with the kernel: rocking, sliding, closed forms."""
