"""Independent answers: rocking, sliding, closed forms."""
