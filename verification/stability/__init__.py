"""The map of stability: how stiff and extreme cases end, each checked, and that none is silently wrong."""
