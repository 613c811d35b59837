"""What a convergence check found: how many answers change with finer steps, stiffer springs, or a rigid block."""

import json
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ValidationError

from overturning.errors import ResultError
from overturning.files import write_text
from overturning.study.answers import Counts
from overturning.validation import format_validation_error

AMPLITUDE_PERTURBATION: Final = 1e-9
"""Share by which the motion is made stronger to see whether an answer hangs on less than is known of it."""

AMPLITUDE_REACH: Final = 0.01
"""Largest change of amplitude, share, under which it is seen whether the azimuth of a fall moves."""

MIN_AZIMUTH_SHIFT_DEG: Final = 30.0
"""Change of its azimuth, degrees, from which a fall is said to move."""

WARN_ABOVE: Final = 0.01
"""Share of changed flags above which the report warns; those are not counted where the ensemble is divided anyway."""


class Outcome(Counts):
    """What changed of one element, whose name is empty for a block."""

    element: str
    undivided: int  # of the cases with an answer in both, those whose ensemble is not divided
    flags_undivided: int  # of these, that fall in one answer and stand in the other
    sides_undivided: int  # of these, that fall to the other side
    fallen_undivided: int  # of the undivided cases, those that fall in both answers
    fallen_agreed: int  # that fall in both answers and whose ensemble members all fall to one side (or none was run)
    sides_agreed: int  # of these, that fall to the other side


class Rigid(Outcome):
    """How far a study's answers differ from those of the exact rigid block."""

    cells: int  # of the study, of blocks that cannot slide


class Repetition(BaseModel):
    """Cases computed again, or why they could not be."""

    block_steps: int
    outcomes: list[Outcome]
    refused: str = ""


class RefinementOfChanges(BaseModel):
    """Cases that changed with finer steps; of these, those looked at, that keep the answer, or lose it to a nudge."""

    changed: int
    looked_at: int
    settled: int
    chaotic: int
    block_steps: int


class AmplitudeChange(BaseModel):
    """Falls of bodies in space run again under motions of amplitudes within ± `AMPLITUDE_REACH`."""

    falls: int  # falls of the study that were run again
    moved: int  # of these, whose azimuth moves by `MIN_AZIMUTH_SHIFT_DEG` or more under one of the motions
    stood: int  # of these, that stand under one of the motions
    weight: float  # sum of the weights of these falls in direction statistics (`model.body.direction_weight`)
    weight_moved: float  # part of it that falls which move have
    block_steps: int


class Convergence(BaseModel):
    """What a convergence check found, as it is kept in ``convergence.json``."""

    seed: int
    wanted: int
    chosen: int
    at_rest: int
    cells: int
    computed: int  # of these, the cells that are not copies of others; where all were chosen nothing was sampled
    study_block_steps: int
    cost: float
    finer_by: int
    stiffer_by: float
    finer: Repetition
    stiffer: Repetition
    settling: RefinementOfChanges
    amplitude: AmplitudeChange | None  # none in planes
    rigid: Rigid | None  # none where no cell is of a block that cannot slide

    def write(self, path: Path) -> None:
        """Write it as JSON."""
        write_text(path, self.model_dump_json(indent=1) + "\n")

    @classmethod
    def read(cls, path: Path) -> "Convergence":
        """Read what `write` wrote; a `ResultError` if it is missing or torn, or says less than this version."""
        try:
            return cls.model_validate(json.loads(path.read_text(encoding="utf-8")))
        except ValidationError as error:
            first = error.errors()[0]
            key = "".join(f"{part}: " for part in [".".join(map(str, first["loc"]))] if part)
            said = f"{key}{format_validation_error(first)}; written by another version"
        except (OSError, ValueError):
            said = "no outcome of a convergence check"
        raise ResultError(f"{path}: {said}; run the study again, which makes the convergence check anew")
