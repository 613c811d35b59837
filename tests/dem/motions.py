"""Simulation of the same cases of a 3-D model under several motions, side by side in the lanes of the kernel."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from overturning.dem.body.plan import SimulationPlan3D
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import plan_simulation, split_into_case_groups
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.results import CaseResults
from overturning.model.stack import Stack
from overturning.motion.motion import Motion

PLAN_FIELDS_PER_CASE = (
    "steps_per_sample",
    "first_simulated_sample",
    "stays_at_rest",
    "has_too_soft_contacts",
    "case_table",
    "orientation_unit_vector_north_east",
)


def simulate_under_each_motion(model: Body | Stack, motions: list[Motion], cases: Cases, **options: Any) -> CaseResults:
    """Simulate n cases under several horizontal motions with the same times; return arrays of shape (motions, n, …).

    The kernel simulates several cases at once, in lanes. An empty lane costs as much as a full one, and outcomes do not
    depend on the lane: see
    `test_stack.test_outcomes_of_a_case_do_not_depend_on_cases_simulated_with_it`.
    """
    assert len({(motion.sample_count, motion.sampling_interval) for motion in motions}) == 1
    assert all(motion.up is None for motion in motions)
    plans = [plan_simulation(model, motion, cases, NumericalOptions(**options)) for motion in motions]
    columns = (
        (*PLAN_FIELDS_PER_CASE, "friction_by_case_and_joint") if isinstance(model, Stack) else PLAN_FIELDS_PER_CASE
    )
    plan = replace(
        plans[0],
        cases=Cases(*(np.tile(getattr(cases, item.name), len(plans)) for item in fields(cases))),
        base_accelerations_by_direction=np.concatenate([one.base_accelerations_by_direction for one in plans]),
        motion_row_by_case=np.concatenate(
            [
                one.motion_row_by_case + number * len(one.base_accelerations_by_direction)
                for number, one in enumerate(plans)
            ]
        ),
        **{name: np.concatenate([getattr(one, name) for one in plans]) for name in columns},
    )
    assert isinstance(plan, SimulationPlan3D)
    found = plan.initial_results_at_rest_or_missing()
    moving = np.flatnonzero(~plan.stays_at_rest & ~plan.has_too_soft_contacts)
    order = moving[np.argsort(plan.parallel_group_by_case[moving], kind="stable")]
    for queue in split_into_case_groups(order, plan.parallel_group_by_case, share_groups_between_two_threads=False):
        found.store_outcomes(queue, plan.simulate_group_with_reruns_on_energy_error(queue, np.zeros(1, np.int64))[0])
    return CaseResults(
        **{name: values.reshape(len(plans), -1, *values.shape[1:]) for name, values in vars(found).items()}
    )
