"""Run the command line as ``python -m overturning``."""

from overturning.cli import main

if __name__ == "__main__":
    main()
