"""How fast and how exact, against peers."""
