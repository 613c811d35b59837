"""Large studies: identical bytes on all platforms; memory, disk space and time."""
