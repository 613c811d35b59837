"""Many cases in space under one motion: planned, shared out to threads, and collected in their own order."""

from functools import partial

from overturning.dem.body import plan as body_plan
from overturning.dem.body.cases import SpaceCases
from overturning.dem.body.results import SpaceResults
from overturning.dem.cluster import run_on_cluster
from overturning.dem.numerics import Numerics
from overturning.dem.run import run_planned
from overturning.model.contact import VertexContact
from overturning.model.shapes import Shape
from overturning.motion.motion import Motion


def run_in_space(
    shape: Shape,
    motion: Motion,
    cases: SpaceCases,
    numerics: Numerics | None = None,
    contact: VertexContact | None = None,
) -> SpaceResults:
    """Run cases of a kind of body under one motion.

    Parameters
    ----------
    shape : Shape
        The kind of body.
    motion : Motion
        The ground's; without a vertical component the base moves level.
    cases : SpaceCases
        Orientations, sizes, friction.
    numerics : Numerics, optional
        How they are computed; `Numerics()` where not given.
    contact : VertexContact, optional
        Springs and dashpots; `VertexContact()` where not given.

    Returns
    -------
    SpaceResults
        In the order of the cases.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    numerics = numerics or Numerics()
    if numerics.client is not None:
        found: SpaceResults = run_on_cluster(partial(run_in_space, shape, contact=contact), motion, cases, numerics)
        return found
    planned = body_plan.plan_in_space(shape, motion, cases, numerics, contact or VertexContact())
    results = planned.uncomputed()
    run_planned(planned, lambda chosen, out: planned.store(results, chosen, out))
    return results
