"""Which way gravestones fall in an earthquake, and how sure one can be."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from overturning.dem.cases import Cases
    from overturning.dem.contact import Contact
    from overturning.dem.run import run_cases
    from overturning.dem.simulate import simulate
    from overturning.dem.solid.simulate import simulate_in_space
    from overturning.dem.solid.trajectory import trajectory_in_space
    from overturning.dem.trajectory import trajectory
    from overturning.motion.motion import Motion

__all__ = ["Cases", "Contact", "Motion", "run_cases", "simulate", "simulate_in_space", "trajectory", "trajectory_in_space"]

# Imported when first asked for, so that the command line starts without numba and xarray.
_MODULES = {
    "Cases": "overturning.dem.cases",
    "Contact": "overturning.dem.contact",
    "Motion": "overturning.motion.motion",
    "run_cases": "overturning.dem.run",
    "simulate": "overturning.dem.simulate",
    "simulate_in_space": "overturning.dem.solid.simulate",
    "trajectory": "overturning.dem.trajectory",
    "trajectory_in_space": "overturning.dem.solid.trajectory",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'overturning' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_MODULES[name]), name)
