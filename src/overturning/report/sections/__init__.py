"""What the report says: functions from the results to a section, those of one subject in a file."""
