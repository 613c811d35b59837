"""What the report says: a file for each section, a function from the results to what stands below its heading."""
