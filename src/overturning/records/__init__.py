"""Strong-motion records: readers of file formats, processing steps, and the class `Record`."""
