"""How large a study may be: the same bytes wherever it runs, memory, disk and time of large ones."""
