"""One module per file format: how its files are read, or why not. Module `table` recognises the format of a file."""
