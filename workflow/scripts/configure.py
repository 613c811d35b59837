"""Write the filled-in study for the jobs of a run."""

import json
from pathlib import Path

text = json.dumps(snakemake.params.study, indent=1, ensure_ascii=False) + "\n"  # noqa: F821
Path(snakemake.output[0]).write_text(text, encoding="utf-8")  # noqa: F821
