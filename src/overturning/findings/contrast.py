"""Comparison of the study with its variants, case by case."""

import numpy as np
from numpy.typing import NDArray

from overturning.findings.results import Results
from overturning.findings.values import Estimate, Finding, Number, estimate
from overturning.model.scene import Scene
from overturning.records.site import Site
from overturning.statistics.bootstrap import mean_over_earthquakes, share_over_earthquakes
from overturning.statistics.elements import ElementFalls, compare_stones, contrast
from overturning.statistics.falls import shares_by_record
from overturning.study.cube import record_provenance
from overturning.study.scenes import NOMINAL, uses_vertical, variant_contact, variant_scene, variant_settings
from overturning.study.schema import Study


class VariantContrast(Finding):
    """Comparison of the study with one variant, over the cases with a known outcome in both."""

    variant: str
    differs_in: list[str]
    """Settings that differ: scene, contact, vertical, site."""
    records: int
    """Records that are compared; of a variant in vertical motion only those that have a vertical component."""
    share_here: Estimate
    """Share of the cases that overturn in the study."""
    share_there: Estimate
    """Share of the cases that overturn in the variant."""
    difference: Estimate
    """First share minus the second, record by record."""
    only_here: Estimate
    only_there: Estimate
    both: Estimate
    same_way: Estimate
    """Share of the falls in both that go within 45° of each other."""
    earlier_here: Estimate
    """Share of the falls in both that are earlier in the study."""
    by_b_over_h: list["ShareByShape"]


class ShareByShape(Finding):
    """Share of the cases of one B/H that overturn in the study and in a variant."""

    b_over_h: float
    share_here: Estimate
    share_there: Estimate


class ElementFinding(Finding):
    """Falls of an element of a scene."""

    setting: str
    """Name of the variant; "nominal" for the study itself."""
    scene: str
    element: str
    cases: int
    falls: int
    share: Number
    falls_first: int
    """Falls in which no other element falls before."""
    median_time_s: Number


class SoilLayer(Finding):
    """Layer of soil."""

    thickness_m: float
    velocity_m_s: float


class GroundFinding(Finding):
    """Falls of the population on one ground and under one factor on the motion."""

    setting: str
    layers: list[SoilLayer]
    """Layers from the surface down; none for the records as they are."""
    factor: float
    median_pga_m_s2: Number
    mean_fall_rate: Number
    """Mean over records."""
    median_fall_rate: Number
    records_with_half_fallen: int


SHARE = "share of the cases that overturn"


def differences(study: Study, variant: str, against: str) -> list[str]:
    """Return the settings in which two variants differ: scene, contact, vertical, site."""
    one, other = variant_settings(study, variant), variant_settings(study, against)
    differing = {
        "scene": (one.scene or study.scene) != (other.scene or study.scene),
        "contact": variant_contact(study, variant) != variant_contact(study, against),
        "vertical": uses_vertical(study, variant) != uses_vertical(study, against),
        "site": one.site != other.site,
    }
    return [name for name, differs in differing.items() if differs]


def compared_records(results: Results, variant: str) -> NDArray[np.intp]:
    """Return the positions of the records that are compared with a variant.

    If the variant differs in vertical motion only, records without a vertical component are left out: both cubes have
    the same cases for them, which show nothing about vertical motion.
    """
    every = np.arange(results.cube.sizes["record"])
    if differences(results.study, NOMINAL, variant) != ["vertical"]:
        return every
    applied = [results.reference_cube(name)["vertical"].to_numpy() == 1 for name in (NOMINAL, variant)]
    return every[np.logical_or(*applied)]


def contrasts_of(results: Results) -> list[VariantContrast]:
    """Compare the study with each of its variants, if a record can be compared."""
    places = {name: compared_records(results, name) for name in results.study.variants}
    return [_contrast(results, name, some) for name, some in places.items() if some.size]


def _contrast(results: Results, variant: str, places: NDArray[np.intp]) -> VariantContrast:
    cubes = [results.reference_cube(name).isel(record=places) for name in (NOMINAL, variant)]
    events = results.events[places]
    found = contrast(compare_stones(*cubes), events)
    here, there = (shares_by_record(cube).to_numpy() for cube in cubes)
    shapes = [shares_by_record(cube, "b_over_h").to_numpy() for cube in cubes]

    by_shape = [
        ShareByShape(
            b_over_h=round(float(ratio), 9),
            share_here=estimate(share_over_earthquakes(one, events), SHARE),
            share_there=estimate(share_over_earthquakes(other, events), SHARE),
        )
        for ratio, one, other in zip(results.cube["b_over_h"].to_numpy(), *shapes, strict=True)
    ]
    return VariantContrast(
        variant=variant,
        differs_in=differences(results.study, NOMINAL, variant),
        records=int(places.size),
        share_here=estimate(share_over_earthquakes(here, events), SHARE),
        share_there=estimate(share_over_earthquakes(there, events), SHARE),
        difference=estimate(mean_over_earthquakes(here - there, events), f"difference of the {SHARE}"),
        only_here=estimate(found.only_this, "share of the cases that overturn in the study only"),
        only_there=estimate(found.only_other, "share of the cases that overturn in the variant only"),
        both=estimate(found.both, "share of the cases that overturn in both"),
        same_way=estimate(found.same_way, "share of the falls in both that go within 45° of each other"),
        earlier_here=estimate(found.earlier, "share of the falls in both that are earlier in the study"),
        by_b_over_h=by_shape,
    )


def elements_of(results: Results) -> list[ElementFinding]:
    """Count the falls of each element of each setting, in scenes of several elements or with several scenes."""
    study = results.study
    several = any("element" in cube.dims for cube in results.cubes.values())
    if not several and not any(variant.scene for variant in study.variants.values()):
        return []
    return [
        _element(name, variant_scene(study, name), row, "element" in cube.dims)
        for name, cube in results.cubes.items()
        for row in results.element_falls[name]
    ]


def _element(setting: str, scene: Scene, row: ElementFalls, several: bool) -> ElementFinding:
    return ElementFinding(
        setting=setting,
        scene=scene.name,
        element=row.name if several else scene.free_names[0],
        cases=row.cases,
        falls=row.falls,
        share=row.share,
        falls_first=row.first,
        median_time_s=row.median_time,
    )


def ground_of(results: Results) -> list[GroundFinding]:
    """Compute the fall rates of the population on each ground; empty without variants through soil or population."""
    sites: dict[str, Site | None] = {NOMINAL: None}
    sites |= {name: variant_settings(results.study, name).site for name in results.study.variants}
    sites = {name: site for name, site in sites.items() if site is not None or name == NOMINAL}
    if len(sites) == 1 or not results.populations:
        return []
    found = []
    for factor in map(float, results.populations[NOMINAL]["amplitude"].to_numpy()):
        for name, site in sites.items():
            rate = results.populations[name].sel(amplitude=factor)["fall_rate"]
            accounts = record_provenance(results.cubes[name]).values()
            layers = site.layers if site is not None else ()
            found.append(
                GroundFinding(
                    setting=name,
                    layers=[SoilLayer(thickness_m=one.thickness_m, velocity_m_s=one.velocity_m_s) for one in layers],
                    factor=factor,
                    median_pga_m_s2=float(np.median([one["peaks"]["pga"][1] for one in accounts])) * factor,
                    mean_fall_rate=float(rate.mean()),
                    median_fall_rate=float(rate.median()),
                    records_with_half_fallen=int((rate >= 0.5).sum()),
                )
            )
    return found
