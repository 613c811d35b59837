"""How exact the answers are, what they cost, and where they end."""
