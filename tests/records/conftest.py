"""Fixtures for the tests of records."""

import os
from pathlib import Path

SAMPLE_RECORD_FOLDER = Path(
    os.environ.get("OVERTURNING_SAMPLE_RECORDS", Path(__file__).parents[2].parent / "shared" / "records")
)

# The folder of real files is not part of the project. Where skipping is forbidden, its tests are not collected.
collect_ignore = (
    ["test_samples.py"] if "OVERTURNING_NO_SKIP" in os.environ and not SAMPLE_RECORD_FOLDER.is_dir() else []
)
