"""One module per file format: how its files are read, or why not. How they are recognised stands in `table`."""
