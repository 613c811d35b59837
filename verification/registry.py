"""What the scripts of this folder measure: the command of each, what it makes, and what its numbers depend on."""

from typing import Final, NamedTuple

KERNELS: Final = ("block", "polygon", "body")
"""Folders of `overturning.dem`, none of which imports another."""

KERNEL: Final = (
    "dem", "model", "motion", "units.py", "records/processing.py", "records/formats/fema_p695.py",
    "study/answers.py",
)  # fmt: skip
"""What a measured number of the kernels depends on: itself, its motions, and how answers are compared."""

STUDY: Final = (*KERNEL, "statistics", "surveys", "study/sweep.py", "study/ensemble.py")
"""What an outcome of a whole study depends on."""

_BACKWARDS: Final = (
    *(room for room in STUDY if room != "surveys"),
    *(f"surveys/{name}.py" for name in ("inversion", "library", "posterior", "responses", "stones")),
)
"""What a motion sought from a survey depends on: not how a survey is compared with a prediction."""

NO_MEASURE_HAS: Final = ("model/mesh.py", "model/polyhedron.py")
"""Bodies given by their vertices: those that are measured are prisms and cylinders."""

_RUN: Final = ("overturning.commands.workflow:sweep", "overturning.commands.workflow:fragility")
_RECORDS: Final = ("config/near-fault.yaml",)
_SHIPPED: Final = tuple(
    f"config/scenes/{name}.yaml"
    for name in ("against-a-wall", "boulder", "gravestone", "monolith", "shaft-alone", "three-tier")
)
_THREE_TIER: Final = _SHIPPED[-1:]


class Measure(NamedTuple):
    """Something that is measured in one go."""

    command: str
    """That makes it again; a part of this folder where it does not begin with ``make``."""
    results: tuple[str, ...]
    """Marks of the docs, files of verification/results, and drawings of docs/images."""
    kernels: tuple[str, ...] = KERNELS
    """Of `KERNELS`, those that it runs."""
    inputs: tuple[str, ...] = ()
    """Files of the project that it reads; with a study also the lines of its records in the record table."""
    rooms: tuple[str, ...] = KERNEL
    """Parts of the package that count, of those that its modules import."""
    source: str = ""
    """Module or `module:function` of this folder, where it is not the measure's name."""
    others: tuple[str, ...] = ()
    """Further ones, also of the package."""

    @property
    def line(self) -> str:
        """The command as it is typed."""
        return self.command if self.command.startswith("make ") else f"python -m verification.{self.command}"


_BENCH: Final = ("bench", "bench-short", "summary", "x86-64-2-cores.csv")
_SCENES: Final = ("scene-speed", "summary", "scenes.csv")
_SPACE: Final = ("space", "space.csv")
_SCALE: Final = ("scale", "scale-on-paper", "scale.csv")

MEASURES: Final[dict[str, Measure]] = {
    "bench:growth": Measure("bench growth", _BENCH, ("block",)),
    "bench:throughput": Measure("bench throughput", _BENCH, ("block",)),
    "bench:sweep": Measure("bench sweep", _BENCH, ("block",), _RECORDS),
    "bench:compilation": Measure("bench compilation", _BENCH, ("block",)),
    "bench:default_study": Measure("bench study", _BENCH, ("block",), _RECORDS),
    "whole_run:whole_run": Measure("bench whole-run", _BENCH, ("block",), _RECORDS, STUDY, others=_RUN),
    "bench:left_out": Measure("bench left-out", (*_BENCH, "left-out"), ("block",), _RECORDS),
    "experiments:default_step": Measure(
        "experiments default-step", ("default-step", "equal-error", "default-step.csv"), ("block",), _RECORDS
    ),
    "experiments:step_and_contact": Measure(
        "experiments step-and-contact", ("step-and-contact",), ("block",), _RECORDS
    ),
    "experiments:fine_steps": Measure("experiments fine-steps", ("fine-steps",), ("block",), _RECORDS),
    "experiments:rigid_limit": Measure(
        "experiments rigid-limit", ("rigid-limit", "rigid-limit-map", "chaos"), ("block",), _RECORDS
    ),
    "experiments:damping_ratio": Measure("experiments damping-ratio", ("damping-ratio",), KERNELS, _RECORDS),
    "experiments:most_friction": Measure("experiments most-friction", ("most-friction",), ("block",), _RECORDS),
    "scenes:speed": Measure("scenes speed", _SCENES, ("polygon",), _SHIPPED),
    "scenes:peers": Measure("scenes peers", _SCENES, ("polygon",), _THREE_TIER),
    "scenes:pillars": Measure("scenes pillars", _SCENES, ("polygon",), _RECORDS),
    "scenes:kernels": Measure(
        "scenes kernels", ("both-kernels", "summary", "both-kernels.csv"), ("block", "polygon")
    ),
    "scenes:steps": Measure("scenes steps", ("scene-steps",), ("polygon",), _THREE_TIER),
    "scene_peers": Measure(
        "scene_peers", ("three-tier-peers.csv",), (), _THREE_TIER, rooms=("model", "motion", "units.py")
    ),
    **{
        f"space:{function}": Measure(f"space {part}", _SPACE, ("body",), inputs)
        for part, function, inputs in (
            ("throughput", "throughput", ()),
            ("memory", "memory", ()),
            ("convergence", "convergence", ()),
            ("study", "study", ("config/in-space.yaml",)),
            ("exactness", "exactness", _RECORDS),
            ("peers", "against_peers", _RECORDS),
        )
    },
    "work_precision": Measure(
        "make verify",
        (
            "steps", "orders", "stiffness", "rigid", "equal-agreement", "summary", "exactness.csv",
            "work-precision.csv", "work-precision-steps.svg", "work-precision-rigid.svg",
        ),
        ("block",),
        _RECORDS,
        source="work_precision.__main__",
        others=("work_precision.page", "work_precision.figures"),
    ),
    "stability": Measure(
        "make verify",
        (
            "stability", "scenes", "reach", "summary", "exactness.csv", "stability-map.svg", "stability-shares.svg",
            "stability-scenes.svg",
        ),
        ("block", "polygon"),
        _SHIPPED,
        source="stability.__main__",
        others=("stability.page", "stability.figures"),
    ),
    "cemetery:planes": Measure(
        "make run STUDY=config/in-space.yaml && python -m verification.cemetery", ("in-space.csv",), ("block", "body"),
        ("config/in-space.yaml",), STUDY, others=_RUN,
    ),
    "cemetery": Measure(
        "make run && python -m verification.cemetery",
        (
            "population", "criteria", "criteria-blocks", "published-surveys", "published-surveys-computed",
            "fall-rate.svg", "criteria.svg", "published-surveys.svg",
        ),
        ("block",),
        (*_RECORDS, "surveys/published.csv"),
        STUDY,
        others=_RUN,
    ),
    "answers": Measure(
        "make run (also of in-space, three-tier, waiau and fine-map) && python -m verification.answers",
        ("found", "rinaldi.svg", "rinaldi-in-space.svg"),
        KERNELS,
        (*(f"config/{name}.yaml" for name in ("near-fault", "in-space", "three-tier", "waiau", "fine-map")), *_SHIPPED),
        STUDY,
        others=_RUN,
    ),
    "soft_ground": Measure(
        "make soil run STUDY=config/soft-ground.yaml && python -m verification.soft_ground",
        ("soft-ground", "soft-ground-answer", "soft-ground-convergence", "soft-ground.csv"), ("block",),
        ("config/soft-ground.yaml",), STUDY, others=_RUN,
    ),
    "backwards_coverage:measured": Measure(
        "backwards_coverage", ("backwards-coverage", "backwards-coverage.csv"), ("body",), _RECORDS,
        _BACKWARDS,
    ),
    "backwards_coverage:ruin": Measure(
        "backwards_coverage", ("example-ruin", "example-ruin.svg"), ("body",),
        ("surveys/example-ruin.csv",), _BACKWARDS,
    ),
    "shaking_table.__main__": Measure(
        "make shaking-table DATA=folder",
        (
            "shaking-table-scores", "shaking-table-damping", "shaking-table-beside", "shaking-table-centres",
            "shaking-table.csv", "shaking-table-reliability.svg",
        ),
        ("block", "body"),
        rooms=(*KERNEL, "statistics"),
    ),
    "shaking_table.small_table": Measure(
        "shaking_table.small_table", ("small-table-scores", "small-table-blocks", "small-table.csv"), ("block",)
    ),
    "scale.same_bytes": Measure(
        "scale bytes slurm", ("scale-bytes", "scale-bytes.csv"), ("block",), rooms=STUDY, others=_RUN
    ),
    "scale.large:measure_chunk": Measure("scale chunk", _SCALE, ("block",), rooms=STUDY),
    "scale.large:measure_gather": Measure("scale gather", _SCALE, (), rooms=("study/gather.py",)),
    **{
        f"scale {part}": Measure(
            f"scale {part}", _SCALE, (), rooms=("statistics", "study/cube.py"), source="scale.large:measure_lazily"
        )
        for part in ("lazy", "lazy-space")
    },
    "scale.on_paper": Measure("scale planning", _SCALE, (), rooms=()),
    "faults.__main__": Measure("make faults", ("faults",), (), rooms=("study/resume.py", "study/parts.py")),
    "mutants.__main__": Measure("make mutants", ("mutants", "mutants.csv"), (), rooms=()),
}  # fmt: skip
