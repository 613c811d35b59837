"""Directions in which gravestones fall in earthquakes, simulated from strong-motion records, with uncertainty.

`read` reads a record, `simulate` simulates blocks or scenes under it for each azimuth, `trajectory` returns the path of
one case, and `run_study` runs a small study:

>>> import overturning
>>> motion = overturning.Motion.sine(amplitude=6.0, period=0.8, azimuth_deg=60)
>>> outcome = overturning.simulate(motion, azimuth_deg=range(0, 360, 30), height=[0.6], b_over_h=[0.3])
>>> outcome.overturned.dims
('azimuth', 'height', 'b_over_h', 'friction')

Azimuths are degrees clockwise from north; other units are SI. A large study is a project with a workflow; create one
with `overturning init FOLDER`.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from overturning import findings, plot
    from overturning.dem.run import run_cases
    from overturning.dem.simulate import simulate
    from overturning.dem.trajectory import trajectory
    from overturning.model.body import Body
    from overturning.model.cases import Cases
    from overturning.model.contact import Contact, VertexContact
    from overturning.model.scene import Scene, gravestone, load_scene
    from overturning.model.stack import Stack
    from overturning.motion.motion import Motion
    from overturning.records.read import read
    from overturning.records.record import Record
    from overturning.study.cube import open_cube
    from overturning.study.small import run_study, to_dataframe
    from overturning.surveys.frame import read_survey

    __version__: str

__all__ = [
    "Body",
    "Cases",
    "Contact",
    "Motion",
    "Record",
    "Scene",
    "Stack",
    "VertexContact",
    "findings",
    "gravestone",
    "load_scene",
    "open_cube",
    "plot",
    "read",
    "read_survey",
    "run_cases",
    "run_study",
    "simulate",
    "to_dataframe",
    "trajectory",
]

# Imported on first use, so that the command line starts without importing numba and xarray.
_MODULE_BY_PUBLIC_NAME = {
    "Body": "overturning.model.body",
    "Cases": "overturning.model.cases",
    "Contact": "overturning.model.contact",
    "Motion": "overturning.motion.motion",
    "Record": "overturning.records.record",
    "Scene": "overturning.model.scene",
    "Stack": "overturning.model.stack",
    "VertexContact": "overturning.model.contact",
    "gravestone": "overturning.model.scene",
    "load_scene": "overturning.model.scene",
    "open_cube": "overturning.study.cube",
    "read": "overturning.records.read",
    "read_survey": "overturning.surveys.frame",
    "run_cases": "overturning.dem.run",
    "run_study": "overturning.study.small",
    "simulate": "overturning.dem.simulate",
    "to_dataframe": "overturning.study.small",
    "trajectory": "overturning.dem.trajectory",
}


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib import metadata

        return metadata.version("overturning")
    from importlib import import_module

    if name == "findings":
        return import_module("overturning.findings")
    if name not in {"plot", *_MODULE_BY_PUBLIC_NAME}:
        raise AttributeError(f"module 'overturning' has no attribute {name!r}")
    plot = import_module("overturning.plot")  # gives motions and records their method `plot`
    if name == "plot":
        return plot
    return getattr(import_module(_MODULE_BY_PUBLIC_NAME[name]), name)
