"""Which scene a study, or a variant of it, has."""

from overturning.dem.polygon.scene import Scene
from overturning.errors import ConfigError
from overturning.study.config import Study

NOMINAL = "nominal"
"""Name of the study's own setting among its variants."""


def scene_of(study: Study, variant: str = NOMINAL) -> Scene | None:
    """The scene of a variant; None where the study is of a single block.

    Raises
    ------
    ConfigError
        If the study has no such variant.
    """
    if variant == NOMINAL:
        return study.scene
    if variant not in study.variants:
        raise ConfigError(f"{study.name}: no variant {variant!r}; known: {', '.join([NOMINAL, *study.variants])}")
    return study.variants[variant].scene or study.scene
