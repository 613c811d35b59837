"""`python -m verification.slip_and_twist`: error of the slip and the twist of standing stones against the time step.

The shaft of the grave `three-tier`, on its two bases (a stack) and on the ground by itself (a body), is simulated under
the 28 near-field records, at two amplitudes, eight orientations and two friction coefficients, with several time steps.
The finest step is the reference.
"""

from collections.abc import Sequence
from typing import Annotated, Final

import numpy as np
import pandas as pd
import typer

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import load_scene
from overturning.model.stack import Stack
from overturning.surveys.library import candidate_motions_from_shipped_records
from overturning.units import CM
from verification.tables import markdown_table, update_marked_tables_and_sentences_in_docs

TIME_STEP_DIVISORS: Final = (1, 2, 4, 16)
"""Numbers of parts into which the automatic step is divided; the last is the reference."""

NEAR_FIELD_RECORD_COUNT: Final = 28
"""Number of near-field records of FEMA P-695, the first of the library."""

AMPLITUDE_FACTORS: Final = (0.6, 1.0)
STONE_ORIENTATIONS_DEG: Final = 22.5 * np.arange(8)
FRICTIONS: Final = (0.5, 0.7)

MIN_SLIP_M_AND_TWIST_DEG_FOR_RELATIVE_ERROR: Final = {"slip": 0.001, "twist": 0.2}
"""Least slip (m) and twist (degrees) in the reference of the stones whose relative error is measured."""

PRINT_FACTOR_AND_UNIT_BY_QUANTITY: Final = {"slip": (1.0 / CM, " cm"), "twist": (1.0, "°")}
"""Factor and unit with which a value is printed."""

EXCEEDANCE_PROBABILITY_OF_TABLE_QUANTILES: Final = 0.1
"""Share of the standing stones that exceed the slip or twist in the last columns of the table."""


def simulate_flag_slip_and_twist_of_shaft(
    model_name: str, model: Stack | Body, height: float, b_over_h: float, threads: int
) -> pd.DataFrame:
    """Simulate a shaft; return overturning flag, final slip (m) and |twist| (degrees) by case and time-step divisor."""
    axes = np.meshgrid(STONE_ORIENTATIONS_DEG, FRICTIONS, AMPLITUDE_FACTORS, indexing="ij")
    orientation, friction, amplitude = (values.ravel() for values in axes)
    cases, rows = Cases(orientation, height, b_over_h, friction, amplitude), []
    for record, candidate in enumerate(candidate_motions_from_shipped_records()[:NEAR_FIELD_RECORD_COUNT]):
        for refinement in TIME_STEP_DIVISORS:
            found = simulate_cases(
                model, candidate.motion, cases, NumericalOptions(refinement=refinement, threads=threads)
            )
            overturned, north, east, twist = (
                np.asarray(values).reshape(len(orientation), -1)[:, -1]
                for values in (
                    found.overturned, found.residual_slip_north, found.residual_slip_east, found.residual_twist
                )
            )  # fmt: skip
            number = record * len(orientation) + np.arange(len(orientation))
            rows.append(pd.DataFrame({
                "model": model_name, "refinement": refinement, "case": number, "overturned": overturned,
                "slip": np.hypot(north, east), "twist": np.abs(twist),
            }))  # fmt: skip
    return pd.concat(rows, ignore_index=True)


def absolute_relative_errors_of_large_values(
    values: FloatArray, reference_values: FloatArray, min_compared_reference_value: float
) -> FloatArray:
    """Return the absolute relative errors of the values whose reference value is at least a limit."""
    counted = reference_values >= min_compared_reference_value
    return np.asarray(np.abs(values[counted] / reference_values[counted] - 1.0))


def slip_and_twist_error_table(rows_by_case_and_time_step: pd.DataFrame) -> str:
    """Return the table of the errors of slip and twist by shaft and time step, as Markdown."""
    lines = []
    for name, mine in rows_by_case_and_time_step.groupby("model", sort=False):
        by_step = {step: one.set_index("case") for step, one in mine.groupby("refinement")}
        standing = pd.concat([one["overturned"] == 0 for one in by_step.values()], axis=1).all(axis=1)
        reference = by_step[TIME_STEP_DIVISORS[-1]][standing]
        for quantity, (factor, unit) in PRINT_FACTOR_AND_UNIT_BY_QUANTITY.items():
            exceeded_by_reference = factor * reference[quantity].quantile(1 - EXCEEDANCE_PROBABILITY_OF_TABLE_QUANTILES)
            for refinement in TIME_STEP_DIVISORS[:-1]:
                values = by_step[refinement][standing][quantity]
                error = absolute_relative_errors_of_large_values(
                    values.to_numpy(),
                    reference[quantity].to_numpy(),
                    MIN_SLIP_M_AND_TWIST_DEG_FOR_RELATIVE_ERROR[quantity],
                )
                lines.append((
                    name, quantity, f"{1 / refinement:g}", error.size,
                    f"{100 * np.median(error):.2g} %", f"{100 * np.quantile(error, 0.9):.2g} %",
                    f"{factor * values.quantile(1 - EXCEEDANCE_PROBABILITY_OF_TABLE_QUANTILES):.3g}{unit}",
                    f"{exceeded_by_reference:.3g}{unit}",
                ))  # fmt: skip
    header = (
        "shaft", "quantity", "share of the automatic step", "stones", "median error", "error exceeded by a tenth",
        "exceeded by a tenth of standing shafts", "the same, finest step",
    )  # fmt: skip
    return markdown_table(header, lines)


def main(threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2) -> None:
    """Simulate the shaft of a grave on its bases and on the ground, and write the table of docs/validation.md."""
    scene = load_scene("three-tier")
    height, b_over_h = reference_element_height_and_b_over_h(scene)
    models: Sequence[tuple[str, Stack | Body]] = [("on two bases", Stack(scene)), ("on the ground", Body())]
    rows = pd.concat(
        [simulate_flag_slip_and_twist_of_shaft(*one, height, b_over_h, threads) for one in models], ignore_index=True
    )
    update_marked_tables_and_sentences_in_docs({"slip-and-twist": slip_and_twist_error_table(rows)})


if __name__ == "__main__":
    typer.run(main)
