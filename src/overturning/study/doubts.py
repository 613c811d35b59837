"""Warnings about implausible values of a study, with the likely cause, such as another unit."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.polygon.prepare import reason_scene_moves_by_itself
from overturning.model.geometry import rounded_reference_height_and_b_over_h
from overturning.model.plane_weights import plane_azimuths_alone_impose_fall_axis
from overturning.model.scene import Scene
from overturning.model.stack_checks import unsimulated_overhang_contact_warnings
from overturning.model.stack_stones import stack_stones
from overturning.model.symmetry import PLANE_SYMMETRY_PERIOD_DEG
from overturning.motion.soil import RockHalfSpace, SoilLayer
from overturning.records.site import SoilSite
from overturning.settings import RELATIVE_TOLERANCE_OUTSIDE_GRID, StonePopulation, UniformRange
from overturning.study.grounds import soil_setting_keys_and_values_of_study
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, names_of_settings_in_which_variants_differ
from overturning.study.schema import Study
from overturning.study.values import ValueRange
from overturning.units import STANDARD_GRAVITY

MIN_PLAUSIBLE_SOIL_VELOCITY_M_S: Final = 30.0
"""Smallest plausible shear-wave velocity of a layer, m/s; mud and peat have more."""

MAX_PLAUSIBLE_FRICTION: Final = 3.0
"""Largest plausible friction coefficient (arctan 3 = 72°)."""

MAX_PLAUSIBLE_B_OVER_H: Final = 1.5
"""Largest plausible B/H; a wider block slides and hardly ever rocks."""

MAX_PLAUSIBLE_AMPLITUDE_FACTOR: Final = 10.0
"""Largest plausible factor on a record."""

MAX_PLAUSIBLE_REST_PENETRATION_OVER_WIDTH: Final = 0.1
"""Largest plausible penetration of a block at rest, as a share of its width; deeper corners are no contacts."""

PLAUSIBLE_DENSITY_RANGE_KG_M3: Final = (1000.0, 8000.0)
"""Range of plausible densities, kg/m³: water to above steel."""

MAX_PLAUSIBLE_POPULATION_SHARE_OUTSIDE_GRID: Final = 0.2
"""Largest plausible share of a population outside the grid of the study."""


def implausible_setting_warnings(study: Study) -> Iterator[str]:
    """Yield a warning for each implausible value in a study, with key, value, limit and likely cause."""
    yield from _too_few_azimuths_warnings(study)
    yield from _compared_variant_with_several_changes_warnings(study)
    yield from _repeated_variant_warnings(study)
    yield from _block_friction_amplitude_and_contact_warnings(study)
    for key, site in soil_setting_keys_and_values_of_study(study):
        yield from _soil_layer_warnings(key, site)
    scenes = {"scene": study.scene} | {f"variants.{name}.scene": one.scene for name, one in study.variants.items()}
    for key, scene in scenes.items():
        if scene is not None:
            yield from _scene_material_warnings(key, scene)
            if study.orientation is None:
                yield from _warnings_if_scene_moves_without_shaking(key, scene, study)
            elif study.is_stack:
                yield from _unmodelled_stack_contact_warnings(key, scene, study)
    if study.population is not None:
        yield from _population_outside_grid_warnings(study, study.population)


def _compared_variant_with_several_changes_warnings(study: Study) -> Iterator[str]:
    """Yield a warning if the variant that is compared with the study differs from it in more than one setting."""
    if (variant := study.primary.against) is None:
        return
    settings = names_of_settings_in_which_variants_differ(study, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant)
    if len(settings) > 1:
        names = f"{', '.join(settings[:-1])} and {settings[-1]}"
        yield (
            f"primary.against: the variant {variant} differs from the study in {names}; no difference can be credited "
            "to one of them. Let variants differ in one setting each"
        )


def _repeated_variant_warnings(study: Study) -> Iterator[str]:
    """Yield a warning for each variant of a study whose settings equal those of the study or of an earlier variant."""
    names = [NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, *study.variants]
    for place, name in enumerate(names[1:], 1):
        for earlier in names[:place]:
            if not names_of_settings_in_which_variants_differ(study, earlier, name):
                whose = "the study" if earlier == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS else f"the variant {earlier}"
                same = f"its settings are those of {whose}, and so are its outcomes"
                yield f"variants.{name}: {same}; change or leave it out"
                break


def _too_few_azimuths_warnings(study: Study) -> Iterator[str]:
    """Yield a warning if a 2-D study has so few azimuths that they, not the motion, determine the axis of the falls."""
    azimuths = study.azimuths_or_orientations_deg
    if study.orientation is None and plane_azimuths_alone_impose_fall_axis(azimuths):
        planes = sorted({azimuth % PLANE_SYMMETRY_PERIOD_DEG for azimuth in azimuths})
        which = f"planes along {_first_numbers_and_rest_count(planes)}" if len(planes) > 1 else f"{planes[0]:g} only"
        yield (
            f"azimuth: {which} (degrees); falls lie in these planes whatever the motion, so the report gives no "
            "alignment and no mean axis or direction. Give equal steps over 180 or 360 degrees"
        )


def warnings_on_ranges_not_reaching_their_stop(study_content: Mapping[str, Any]) -> Iterator[str]:
    """Yield a warning for each range (start, stop, step) in a study file whose steps do not end exactly at its stop.

    `study_content` holds the keys and values of a valid study file.
    """
    for key in ("height", "b_over_h", "friction", "amplitude"):
        value = study_content.get(key)
        if isinstance(value, Mapping) and {"start", "stop", "step"} <= value.keys():
            given = ValueRange.model_validate(dict(value))
            last = given.expand_values()[-1]
            if abs(last - given.stop) > 1e-9:
                yield f"{key}: steps of {given.step:g} end at {last:g}, before stop {given.stop:g}; change step or stop"


def _block_friction_amplitude_and_contact_warnings(study: Study) -> Iterator[str]:
    """Yield a warning for each implausible B/H, friction, amplitude, density or contact stiffness in a study."""
    vertices = study.body is not None and study.body.vertices is not None
    own = rounded_reference_height_and_b_over_h(study.scene)[1]
    shapes = [one for one in study.b_over_h if one > MAX_PLAUSIBLE_B_OVER_H and not vertices and one != own]
    if shapes:
        yield (
            f"b_over_h: {_first_numbers_and_rest_count(shapes)} above {MAX_PLAUSIBLE_B_OVER_H:g}; H/B? Give width over "
            f"height: {_first_numbers_and_rest_count([1 / one for one in shapes])}"
        )
    yield from _friction_warnings("friction", study.friction)
    factors = [one for one in study.amplitude if one > MAX_PLAUSIBLE_AMPLITUDE_FACTOR]
    if factors:
        yield (
            f"amplitude: {_first_numbers_and_rest_count(factors)} above {MAX_PLAUSIBLE_AMPLITUDE_FACTOR:g}; per cent, "
            "or a peak? Give factors on each record, 1 for the record as it is"
        )
    yield from _density_warnings("density", study.density)
    contacts = {"contact": study.contact} | {
        f"variants.{name}.contact": one.contact for name, one in study.variants.items() if one.contact is not None
    }
    for key, contact in contacts.items():
        # A block of mass ρ B H sinks by m g / (2 K), so relative to B by ρ H g / (2 K).
        weight = study.density * max(study.height) * STANDARD_GRAVITY
        if (
            contact.stiffness != "auto"
            and study.body is None
            and weight > 2 * MAX_PLAUSIBLE_REST_PENETRATION_OVER_WIDTH * contact.stiffness
        ):
            yield (
                f"{key}.stiffness: {contact.stiffness:g} N/m; a block {max(study.height):g} m high sinks by "
                f"{weight / (2 * contact.stiffness):.3g} of its width; give at least "
                f"{weight / (2 * MAX_PLAUSIBLE_REST_PENETRATION_OVER_WIDTH):.2g} N/m, or auto"
            )


def _friction_warnings(study_file_key: str, friction_coefficients: tuple[float, ...]) -> Iterator[str]:
    """Yield a warning if friction coefficients are implausibly large, such as angles in degrees."""
    doubtful = [one for one in friction_coefficients if one > MAX_PLAUSIBLE_FRICTION]
    if doubtful:
        angles = [math.tan(math.radians(one)) for one in doubtful if one < 90]
        instead = (
            f" An angle of friction in degrees? Give its tangent: {_first_numbers_and_rest_count(angles)}"
            if angles
            else " Per cent?"
        )
        yield f"{study_file_key}: {_first_numbers_and_rest_count(doubtful)} above {MAX_PLAUSIBLE_FRICTION:g}.{instead}"


def _density_warnings(study_file_key: str, density_kg_m3: float) -> Iterator[str]:
    """Yield a warning if a density is implausible, such as a value in g/cm³ instead of kg/m³."""
    low, high = PLAUSIBLE_DENSITY_RANGE_KG_M3
    if not low <= density_kg_m3 <= high:
        light = "; kN/m³? Times 102" if density_kg_m3 < 100 else ""
        cause = "; g/cm³? Times 1000" if low <= 1000 * density_kg_m3 <= high else light
        yield f"{study_file_key}: {density_kg_m3:g} kg/m³ outside {low:,.0f} to {high:,.0f} kg/m³{cause}"


def _soil_layer_warnings(study_file_key: str, soil_site: SoilSite) -> Iterator[str]:
    """Yield a warning for each implausible shear-wave velocity or density of soil layers and the rock below them."""
    below: list[tuple[str, SoilLayer | RockHalfSpace]] = [
        (f"layers.{number}", one) for number, one in enumerate(soil_site.layers)
    ]
    for name, one in [*below, ("rock", soil_site.rock)]:
        velocity = one.velocity_m_s
        if velocity < MIN_PLAUSIBLE_SOIL_VELOCITY_M_S:
            instead = f"km/s? Give {1000 * velocity:g}" if 1000 * velocity <= 1e4 else "another unit?"
            bound = f"{MIN_PLAUSIBLE_SOIL_VELOCITY_M_S:g} m/s"
            yield f"{study_file_key}.{name}.velocity_m_s: {velocity:g} m/s below {bound}; {instead}"
        yield from _density_warnings(f"{study_file_key}.{name}.density_kg_m3", one.density_kg_m3)


def _scene_material_warnings(study_file_key: str, scene: Scene) -> Iterator[str]:
    """Yield a warning for each implausible density or friction coefficient in a scene file."""
    for name, material in scene.materials.items():
        yield from _density_warnings(f"{study_file_key}.materials.{name}.density", material.density)
    for number, law in enumerate(scene.contacts):
        if law.friction is not None:
            yield from _friction_warnings(f"{study_file_key}.contacts.{number}.friction", (law.friction,))


def _warnings_if_scene_moves_without_shaking(study_file_key: str, scene: Scene, study: Study) -> Iterator[str]:
    """Yield a warning for the first B/H of a study at which a 2-D scene falls or slides without ground motion."""
    for b_over_h in study.b_over_h:
        reason = reason_scene_moves_by_itself(scene, None, b_over_h, min(study.friction))
        if reason:
            yield f"{study_file_key}: at B/H {b_over_h:g}, {reason}"
            return


def _unmodelled_stack_contact_warnings(study_file_key: str, scene: Scene, study: Study) -> Iterator[str]:
    """Yield a warning for the first B/H at which overhanging stones of a 3-D stack could touch a face not modelled."""
    for b_over_h in study.b_over_h:
        if touches := unsimulated_overhang_contact_warnings(stack_stones(scene, None, b_over_h)):
            yield (
                f"{study_file_key}: at B/H {b_over_h:g}, {'; '.join(touches)}. The simulation does not have this "
                "contact: outcomes of stones with a larger peak_tilt are uncertain"
            )
            return


def _population_outside_grid_warnings(study: Study, population: StonePopulation) -> Iterator[str]:
    """Yield a warning if many stones of a population lie outside the heights, B/H or frictions that are simulated.

    The outcome of such a stone is that of the nearest simulated value. Sizes are uniformly distributed, so 50 quantiles
    represent the stones.
    """
    quantile = (np.arange(50) + 0.5) / 50

    def values_at_evenly_spaced_quantiles(uniform_range: UniformRange) -> FloatArray:
        """Return the values of a uniform distribution at 50 evenly spaced probabilities."""
        return np.asarray(uniform_range.low + (uniform_range.high - uniform_range.low) * quantile)

    width, height = (
        values_at_evenly_spaced_quantiles(population.width),
        values_at_evenly_spaced_quantiles(population.height),
    )
    sizes = (
        ("height", "population.height", height, study.height),
        ("b_over_h", "population.width over height", width / height[:, None], study.b_over_h),
        ("friction", "population.friction", values_at_evenly_spaced_quantiles(population.friction), study.friction),
    )
    for key, of, drawn, grid in sizes:
        low, high = (1 - RELATIVE_TOLERANCE_OUTSIDE_GRID) * min(grid), (1 + RELATIVE_TOLERANCE_OUTSIDE_GRID) * max(grid)
        outside = float(np.mean((drawn < low) | (drawn > high)))
        if outside > MAX_PLAUSIBLE_POPULATION_SHARE_OUTSIDE_GRID:
            ends = f"{min(grid):g}" if min(grid) == max(grid) else f"{min(grid):g} to {max(grid):g}"
            yield (
                f"{of}: {drawn.min():.3g} to {drawn.max():.3g}, of which {100 * outside:.0f} % outside the study's "
                f"{key}, {ends}; those stones take the nearest value: add values to {key}"
                + ("" if key == "friction" else ", or is a size in centimetres?")
            )


def _first_numbers_and_rest_count(numbers_to_list: list[float]) -> str:
    """Return a text with the first three numbers of a list, and how many more there are."""
    more = f" and {len(numbers_to_list) - 3} more" if len(numbers_to_list) > 3 else ""
    return ", ".join(f"{one:.3g}" for one in numbers_to_list[:3]) + more
