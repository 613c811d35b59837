"""Tables of error against run time in the docs; all rows are in verification/results/work-precision.csv."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO
from overturning.study.ensemble import wilson_95_percent_interval
from verification.measures import convergence_order
from verification.tables import MeasuredNumber, iterate_rows, markdown_table
from verification.work_precision.boundaries import RELATIVE_BOUNDARY_RESOLUTION
from verification.work_precision.parts import COMPARED_SCHEMES

MAX_AND_MIN_STEP_TO_STABLE_STEP_IN_ORDER_FIT: Final = (0.5, 0.05)
"""Largest and smallest Δt/Δt_stable of the fit of the order of convergence."""

SHOWN_TIME_STEP_TO_STABLE_STEP_RATIOS: Final = (1.0, 0.5, 0.12)
SHOWN_ENGINE_TIME_STEPS_S: Final = (1 / 60, 1 / 240, 1 / 960, 1 / 3840)
"""Time steps shown in the docs: of the kernel as Δt/Δt_stable, of the engines in s."""

AGREEMENT_SHARES_FOR_TIME_COMPARISON: Final = (0.9, 0.95, 0.97, 0.98, 0.99)
"""Shares of agreeing cases at which times are compared."""
COMPARED_METHODS: Final = ("exact", "centred", "cundall", "pymunk", "MuJoCo", "Box2D")

_ERROR_HEADERS: Final = ("wrong flags (95 %)", "wrong sides (95 %)", "peak rotation", "boundary")


def mask_of_finer_step_rows_at_default_stiffness(
    rows: pd.DataFrame, sliding_or_rocking_blocks: str
) -> "pd.Series[bool]":
    """Return True for rows of record cases with the default stiffness that are compared with a finer step."""
    own = np.isclose(rows["penetration_ratio"], DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO)
    return (rows["cases_of"] == f"records, {sliding_or_rocking_blocks}") & (rows["against"] == "finer step") & own


def fit_convergence_orders_by_measure_and_scheme(
    rows: pd.DataFrame,
    max_and_min_step_to_stable_step: tuple[float, float] = MAX_AND_MIN_STEP_TO_STABLE_STEP_IN_ORDER_FIT,
) -> dict[str, float]:
    """Return orders of convergence between two Δt/Δt_stable, by error measure and scheme in one name."""
    high, low = max_and_min_step_to_stable_step
    steps = (rows["step_fraction"] <= high) & (rows["step_fraction"] >= low)
    parts = [
        (f"{kind}, {measure}", mask_of_finer_step_rows_at_default_stiffness(rows, kind), measure)
        for kind in ("rocking", "sliding")
        for measure in ("rotation_error", "boundary_shift")
    ]
    found = {}
    for name, part, measure in (*parts, ("energy", rows["against"] == "energy balance", "energy_error")):
        for method in COMPARED_SCHEMES:
            chosen = rows[steps & part & (rows["method"] == method)]
            found[f"{name}, {method}"] = convergence_order(
                chosen["step_fraction"].to_numpy(), chosen[measure].to_numpy()
            )
    return found


def markdown_by_marker(
    rows: pd.DataFrame, convergence_order_by_measure_and_scheme: Mapping[str, float]
) -> dict[str, str]:
    """Return the Markdown tables of error against run time by the name of their marker in the docs."""
    return {
        "steps": _scheme_error_table_against_finer_step(rows),
        "orders": _convergence_order_table(
            convergence_order_by_measure_and_scheme, fit_convergence_orders_by_measure_and_scheme(rows, (1.0, 0.0))
        ),
        "stiffness": _stiffness_error_table(rows),
        "rigid": _table_of_errors_against_rigid_solutions(rows),
        "equal-agreement": table_of_least_time_by_share_of_equal_outcomes(rows),
    }


def work_precision_numbers_for_summary(
    rows: pd.DataFrame, convergence_order_by_measure_and_scheme: Mapping[str, float]
) -> list[MeasuredNumber]:
    """Return numbers for the summary: errors of the default setting, and the lowest order of each scheme."""
    default = rows[(rows["default"] == 1) & rows["method"].isin(COMPARED_SCHEMES)]
    made = []
    for kind in ("rocking", "sliding"):
        (at,) = iterate_rows(default[mask_of_finer_step_rows_at_default_stiffness(default, kind)])
        made += [
            MeasuredNumber(
                f"wrong flags against a far finer step, records, {kind}", 100 * at.wrong_flags / at.cases, "%"
            ),
            MeasuredNumber(
                f"wrong sides against a far finer step, records, {kind}", 100 * at.wrong_sides / at.fallen, "%"
            ),
        ]
    for name in ("sine pulses", "records, no sliding"):
        (at,) = iterate_rows(default[(default["cases_of"] == name) & (default["against"] == "rigid rocking")])
        made.append(MeasuredNumber(f"wrong flags against rigid rocking, {name}", 100 * at.wrong_flags / at.cases, "%"))
    (at,) = iterate_rows(default[default["against"] == "exact sliding"])
    made.append(MeasuredNumber("largest error of peak slip against exact sliding", 100 * at.slip_error, "%"))
    for method in COMPARED_SCHEMES:
        of_rotation = [
            value
            for name, value in convergence_order_by_measure_and_scheme.items()
            if "rotation" in name and name.endswith(method)
        ]
        made.append(MeasuredNumber(f"order of convergence of peak rotation, {method}, least", min(of_rotation)))
    return made


def _share_with_interval(count: float, total: float) -> str:
    """Return a share in percent, its counts and its 95 % interval (Wilson) as text."""
    low, high = map(float, wilson_95_percent_interval(count, total))
    return f"{100 * count / max(total, 1):.2f} % ({int(count)} of {int(total)}; {100 * low:.2f} to {100 * high:.2f})"


def _format_two_significant_digits(value: float, as_percentage: bool = False) -> str:
    """Return a number, or with `as_percentage` a share in %, with two significant digits as text; "–" if missing."""
    if not np.isfinite(value):
        return "–"
    if as_percentage and value == 0:
        return f"< {100 * RELATIVE_BOUNDARY_RESOLUTION:.2g} %"
    return f"{100 * value:.2g} %" if as_percentage else f"{value:.2g}"


def _error_table_cells_of_row(error_row: Any) -> tuple[str, ...]:
    """Return the table cells of wrong flags, wrong sides, rotation error and boundary shift of a row."""
    return (
        _share_with_interval(error_row.wrong_flags, error_row.cases),
        _share_with_interval(error_row.wrong_sides, error_row.fallen),
        _format_two_significant_digits(error_row.rotation_error),
        _format_two_significant_digits(error_row.boundary_shift, as_percentage=True),
    )


def _text_marked_if_default_setting(error_row: Any, text: str) -> str:
    """Return a cell's text, marked if the row is the default setting."""
    return f"{text} **default**" if error_row.default == 1 else text


def _row_mask_of_time_steps_shown_in_docs(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Return True for rows with time steps that the docs show, of any stiffness."""
    steps, engine = rows["step_fraction"], rows["penetration_ratio"].isna()
    own = np.isclose(steps.to_numpy()[:, None], SHOWN_ENGINE_TIME_STEPS_S, rtol=1e-3, atol=0.0).any(axis=1)
    return (steps.isin(SHOWN_TIME_STEP_TO_STABLE_STEP_RATIOS).where(~engine, own) | (rows["method"] == "exact")).astype(
        bool
    )


def table_of_least_time_by_share_of_equal_outcomes(rows: pd.DataFrame) -> str:
    """Return a table of the least time per case at which each method reaches given shares of equal outcomes.

    The outcomes are compared with those of the rigid rocking block; the last row has the highest share reached.
    """
    of = rows[rows["cases_of"] == "records, no sliding"]
    agreement = 1.0 - of["disagree"] / of["shared"]
    most = {name: agreement[of["method"] == name].max() for name in COMPARED_METHODS if (of["method"] == name).any()}

    def least_time_per_case_text(method_name: str, min_agreement_share: float) -> str:
        """Return the least time per case, ms, at which a method agrees in a share of the cases, as text; or "–"."""
        seconds = of["seconds_per_case"][(of["method"] == method_name) & (agreement >= min_agreement_share)].min()
        return f"{1e3 * seconds:.3g} ms" if np.isfinite(seconds) else "–"

    lines = [
        (f"{100 * least:g} %", *(least_time_per_case_text(name, least) for name in most))
        for least in AGREEMENT_SHARES_FOR_TIME_COMPARISON
    ]
    best = [f"{100 * share:.1f} % in {least_time_per_case_text(name, share)}" for name, share in most.items()]
    return markdown_table(
        (f"agreement in {of['shared'].max():.0f} cases", *most), [*lines, ("highest agreement", *best)]
    )


def _scheme_error_table_against_finer_step(rows: pd.DataFrame) -> str:
    """Return the table of errors of both schemes against a far finer step."""
    chosen = rows[
        (
            mask_of_finer_step_rows_at_default_stiffness(rows, "rocking")
            | mask_of_finer_step_rows_at_default_stiffness(rows, "sliding")
        )
        & _row_mask_of_time_steps_shown_in_docs(rows)
    ]
    lines = [
        (
            at.cases_of,
            _text_marked_if_default_setting(at, at.method),
            f"{at.step_fraction:g}",
            f"{at.seconds_per_case:.2g}",
            *_error_table_cells_of_row(at),
        )
        for at in iterate_rows(chosen)
    ]
    return markdown_table(("cases", "scheme", "Δt/Δt stable", "s per case", *_ERROR_HEADERS), lines)


def _stiffness_error_table(rows: pd.DataFrame) -> str:
    """Return the table of errors of the default scheme and step over stiffness."""
    ratio = rows["penetration_ratio"]
    several = (
        ratio.notna()
        & ~np.isclose(ratio, DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO)
        & (rows["against"] == "finer step")
    )
    names = {"finer step": "same springs, finer steps", "stiffest springs": "stiffest springs, finer steps"}
    lines = [
        (at.cases_of, _text_marked_if_default_setting(at, f"{at.penetration_ratio:.0e}"), f"{at.seconds_per_case:.2g}",
         names[at.against], *_error_table_cells_of_row(at))
        for at in iterate_rows(rows[several | (rows["against"] == "stiffest springs")])
    ]  # fmt: skip
    return markdown_table(("cases", "δ/B", "s per case", "against", *_ERROR_HEADERS), lines)


def _table_of_errors_against_rigid_solutions(rows: pd.DataFrame) -> str:
    """Return the table of errors against rigid rocking and sliding, engines included."""
    head = (
        "cases",
        "method",
        "step",
        "δ/B",
        "s per case",
        "wrong flags (95 %)",
        "wrong sides",
        "peak rotation",
        "peak slip",
    )
    lines = []
    for at in iterate_rows(
        rows[rows["against"].isin(("rigid rocking", "exact sliding")) & _row_mask_of_time_steps_shown_in_docs(rows)]
    ):
        engine, counted = not np.isfinite(at.penetration_ratio), np.isfinite(at.wrong_flags)
        lines.append((
            at.cases_of,
            _text_marked_if_default_setting(at, at.method),
            _time_step_or_taylor_order_label(at),
            "–" if engine else f"{at.penetration_ratio:.0e}",
            f"{at.seconds_per_case:.2g}",
            _share_with_interval(at.wrong_flags, at.cases) if counted else "–",
            f"{at.wrong_sides:.0f} of {at.fallen:.0f}" if counted else "–",
            _format_two_significant_digits(at.rotation_error),
            _format_two_significant_digits(at.slip_error, as_percentage=True),
        ))  # fmt: skip
    return markdown_table(head, lines)


def _time_step_or_taylor_order_label(error_row: Any) -> str:
    """Return the label of a row: Δt/Δt_stable of the kernel, step in s of an engine, or order of the exact block."""
    if error_row.method == "exact":
        return f"order {error_row.step_fraction:g}"
    return (
        f"{error_row.step_fraction:g}"
        if np.isfinite(error_row.penetration_ratio)
        else f"1/{1 / error_row.step_fraction:.0f} s"
    )


def _convergence_order_table(
    order_in_fit_range_by_measure: Mapping[str, float], order_over_all_steps_by_measure: Mapping[str, float]
) -> str:
    """Return the table of orders of convergence, in the range of the fit and over all steps."""

    def order_text(value: float) -> str:
        """Return an order of convergence as text."""
        return f"{value:.2f}" if np.isfinite(value) else "shifts below what bisection resolves"

    lines = [
        (name.replace("_", " "), order_text(value), order_text(order_over_all_steps_by_measure[name]))
        for name, value in order_in_fit_range_by_measure.items()
    ]
    return markdown_table(("measure", "order", "over all steps"), lines)
