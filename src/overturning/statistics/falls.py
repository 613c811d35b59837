"""Directions of falls: flags by azimuth, shares of cases that overturn, mean fall directions and axes.

In shares and means each plane counts once, and azimuths added to a grid share the weight of their neighbourhood (see
`Model.falls`). ``over`` names dimensions that are averaged together with the direction, each case alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr

from overturning.model.falls import model_of
from overturning.model.planes import FALLS, fall_probability, period_of
from overturning.model.symmetry import PLANE_PERIOD, nearest_planes
from overturning.model.variables import PLANE_ENSEMBLE_VARIABLES, VARIABLES, answered
from overturning.statistics.circular import NO_DIRECTION


def whole_circle(cube: xr.Dataset) -> xr.Dataset:
    """Return a planar cube, or a variable of one, with the opposites of all azimuths, in ascending order.

    Motions along φ and φ + 180° are one plane and one outcome. Where the cube holds one of them, the other is that
    one seen from behind; where it holds both, both stay as they are. Of a scene that is not its own mirror image, where
    they are two cases, opposites are added where the cube knows nothing of them, all missing. Lazy where the cube is.
    """
    azimuth = cube["azimuth"].to_numpy()
    opposite = np.round((azimuth.astype(np.float64) + 180.0) % 360.0, 10).astype(azimuth.dtype)
    everywhere = np.union1d(azimuth, opposite)
    if np.array_equal(everywhere, azimuth):
        return cube
    sources = nearest_planes(azimuth, everywhere, period_of(cube))
    if period_of(cube) != PLANE_PERIOD:
        return cube.reindex(azimuth=everywhere[np.isin(everywhere, azimuth) | ~sources.known])
    turned = cube.isel(azimuth=sources.cell).assign_coords(azimuth=("azimuth", everywhere, cube["azimuth"].attrs))
    behind = xr.DataArray(sources.mirrored, dims="azimuth")
    changed = {}
    for variable in (*VARIABLES, *PLANE_ENSEMBLE_VARIABLES):
        if variable.name in cube and (variable.odd or variable.exchanged):
            values, seen = turned[variable.name], turned[variable.exchanged or variable.name]
            changed[variable.name] = xr.where(behind, -seen if variable.odd else seen, values).transpose(*values.dims)
            changed[variable.name].attrs = values.attrs
    return turned.assign(changed)


def falls_towards(cube: xr.Dataset, *, ensemble: bool = False) -> xr.DataArray:
    """Count the falls towards each azimuth: 1 or 0, NaN for a missing outcome; as lazy as the cube.

    A block that falls towards −1 at φ falls towards φ + 180°. So each fall stands exactly once in the result, at
    the azimuth it goes to, whether the cube holds one or both azimuths of its plane. Of a scene that is not its own
    mirror image the falls of two cases go to an azimuth, its own and that of the opposite one.

    Parameters
    ----------
    cube : Dataset
        With ``overturned`` and ``azimuth``.
    ensemble : bool
        Use probabilities instead of flags (see `fall_probability`).

    Returns
    -------
    DataArray
        Azimuths of `whole_circle`; for a scene without mirror symmetry the opposites are added.
    """
    used = [name for name in (FALLS if ensemble else FALLS[:1]) if name in cube]
    p = fall_probability(whole_circle(cube[used]), ensemble=ensemble)
    falls, azimuth = p["towards"], p["azimuth"]
    if period_of(cube) != PLANE_PERIOD:
        away = p["away"].assign_coords(azimuth=((azimuth + 180) % 360).astype(azimuth.dtype)).sortby("azimuth")
        both = xr.concat(xr.align(falls, away, join="outer"), "side")
        falls = both.sum("side", min_count=1).transpose(*falls.dims)
    return falls.assign_attrs(long_name="falls towards the azimuth", units="1")


def overturns(cube: xr.Dataset) -> xr.DataArray:
    """Return 1 if the block falls to either side, 0 if it stands, NaN for a missing outcome."""
    overturned = cube["overturned"]
    return xr.where(answered(overturned), (overturned != 0).astype("float32"), np.nan).assign_attrs(
        long_name="block overturns to either side", units="1"
    )


def shares_by_record(cube: xr.Dataset, *keep: str) -> xr.DataArray:
    """Compute the share of known cases of each record that overturn, for each value of the kept dimensions."""
    falls = overturns(cube)
    shares = falls.mean([name for name in falls.dims if name not in ("record", *keep)]).compute()
    return shares.transpose(..., "record").astype("float64")


def flag_changes_between_neighbours(cube: xr.Dataset, dim: str) -> tuple[int, int]:
    """Count neighbouring cells along a dimension whose outcome differs, and the known pairs of neighbours.

    A grid of azimuths that goes round the compass goes on from its last to its first.
    """
    flags, at = cube["overturned"].compute(), cube[dim].to_numpy().astype(np.float64)
    gap = float(np.diff(at).max(initial=0.0))
    round_about = dim == "azimuth" and at[0] + 360.0 - at[-1] <= gap * (1 + 1e-9)
    beyond = flags.roll({dim: -1}, roll_coords=False) if round_about else flags.shift({dim: -1})
    known = answered(flags) & answered(beyond)
    return int(((flags != beyond) & known).sum()), int(known.sum())


@dataclass(frozen=True)
class BlockRule:
    """Rule that chooses the blocks whose falls are counted under a record.

    Attributes
    ----------
    name : str
        Which blocks count; ``{}`` stands for the directions of the model, such as "plane".
    most : float
        Largest share of the directions in which a block overturns; above 1 for no limit.
    otherwise_all : bool
        Count all blocks of a record under which the rule chooses none; otherwise such a record does not count.
    """

    name: str
    most: float
    otherwise_all: bool = False

    def chosen(self, share: xr.DataArray) -> xr.DataArray:
        """Return True for blocks that count, of the share of directions in which each overturns under a record."""
        if self.most > 1.0:
            return xr.ones_like(share, dtype=bool)
        near = (share > 0) & (share <= self.most) & (share < 1.0)
        return near | ~near.any([name for name in near.dims if name != "record"]) if self.otherwise_all else near


MARGINAL: Final = BlockRule("in at most half of the {}s, or all blocks of a record without such", 0.5, True)
"""Rule of the planar model: blocks that only just fall."""

EVERY_BLOCK: Final = BlockRule("all blocks", 2.0)
"""Rule of the 3-D model, in which a block that falls whichever way it faces still falls where the motion sends it."""

BLOCK_RULES: Final = (
    MARGINAL,
    BlockRule("in at most half of the {}s", 0.5),
    BlockRule("in at most a quarter of the {}s", 0.25),
    BlockRule("in some {}s, but not in all", 1.0),
    EVERY_BLOCK,
)
"""Rules under which a report gives the alignment, to show how far it depends on this choice."""


def rule_of(cube: xr.Dataset) -> BlockRule:
    """Rule that chooses the blocks of a cube: `MARGINAL` for planes, `EVERY_BLOCK` for bodies in space."""
    return MARGINAL if model_of(cube).one_component else EVERY_BLOCK


def overturning_shares(cube: xr.Dataset) -> xr.DataArray:
    """Compute the share of directions in which each block overturns under a record, each plane counted once.

    Directions whose outcome is missing do not count.
    """
    model = model_of(cube)
    once = {model.direction: model.representative(cube)}
    return overturns(cube).isel(once).mean(model.direction).compute()


def informative_blocks(cube: xr.Dataset) -> xr.DataArray:
    """Return True for blocks whose falls are informative about direction; no dimension of direction.

    Where each direction has a component of the motion of its own these only just fall under a record: they overturn in
    some of its planes, and in at most half of them. More slender ones fall in nearly every plane, to whichever side,
    and hide the direction that these show; of a record under which no block only just falls all count. Each plane
    counts once, none whose outcome is missing. Elsewhere all are informative.
    """
    rule = rule_of(cube)
    return xr.DataArray(True) if rule is EVERY_BLOCK else rule.chosen(overturning_shares(cube))


def fall_shares(cube: xr.Dataset, *, over: Sequence[str] = ()) -> xr.DataArray:
    """Compute the share of planes or orientations of known outcome in which a block overturns."""
    model = model_of(cube)
    falls, dims = model.falls(cube), (model.direction, *over)
    weight = falls["weight"].where(falls["falls"].notnull(), 0.0).sum(dims)
    share = (falls["falls"] * falls["weight"]).sum(dims) / weight.where(weight > 0)
    return share.assign_attrs(long_name=f"share of {model.direction}s in which the block falls", units="1")


def fall_vectors(cube: xr.Dataset, *, over: Sequence[str] = (), informative: bool = False) -> xr.Dataset:
    """Sum the variables of `Model.falls`, weighted, so that means can be formed.

    They may be added up further before an angle is taken. With ``informative`` they are of the
    `informative_blocks` alone; ``all_falls`` are those of all blocks.
    """
    model = model_of(cube)
    falls, dims = model.falls(cube), (model.direction, *over)
    weighted = falls.drop_vars("weight") * falls["weight"]
    sums = (weighted.where(informative_blocks(cube)) if informative else weighted).sum(dims)
    return sums.assign(all_falls=weighted["falls"].sum(dims))


def fall_means(cube: xr.Dataset, *, over: Sequence[str] = (), informative: bool = False) -> xr.Dataset:
    """Compute the mean direction towards which blocks fall, and the mean axis of the falls.

    Axes are averaged with their angles doubled (Mardia & Jupp 2000, eqs 2.2.2 to 2.2.4 and section 9.1);
    See `fall_vectors` for ``informative``.

    Returns
    -------
    Dataset
        ``mean_direction`` (degrees, 0 to 360; missing where nothing fell or the falls cancel), ``mean_axis`` (0 to 180;
        missing where nothing fell or all planes overturn alike), ``direction_resultant`` and ``axis_resultant`` (mean
        resultant lengths, 0 to 1, the latter of doubled angles; missing where nothing fell).
    """
    sums = fall_vectors(cube, over=over, informative=informative)
    means = dict[str, xr.DataArray]()
    total = sums["falls"].where(sums["falls"] > 0)
    for kind, full, of in (("direction", 360.0, "fall directions"), ("axis", 180.0, "doubled fall axes")):
        cosine, sine = sums[f"{kind}_cosine"], sums[f"{kind}_sine"]
        length = (xr.apply_ufunc(np.hypot, cosine, sine, dask="allowed") / total).clip(0, 1)
        turned = xr.apply_ufunc(np.arctan2, sine, cosine, dask="allowed")
        angle = (turned * (full / (2 * np.pi)) % full).where(length > NO_DIRECTION)
        angle.attrs = {"long_name": f"mean fall {kind}", "units": "degree"}
        length.attrs = {"long_name": f"mean resultant length of {of}", "units": "1"}
        means |= {f"mean_{kind}": angle, f"{kind}_resultant": length}
    return xr.Dataset(means)


def fall_alignment(sums: xr.Dataset, reference_deg: xr.DataArray, *, axial: bool = True) -> xr.Dataset:
    """Compute the mean cosine and sine of the angle from a reference azimuth to the falls, doubled for an axis.

    Parameters
    ----------
    sums : Dataset
        From `fall_vectors`.
    reference_deg : DataArray
        Azimuth of each record, degrees; NaN where there is none.
    axial : bool
        Take falls and reference as axes.

    Returns
    -------
    Dataset
        ``cosine`` (1 where all falls go along the reference, 0 where they do not heed it, −1 where they go across an
        axis or against a direction) and ``sine``; missing where nothing falls or there is no reference.
    """
    kind, times = ("axis", 2) if axial else ("direction", 1)
    cosine, sine = sums[f"{kind}_cosine"], sums[f"{kind}_sine"]
    total, turn = sums["falls"].where(sums["falls"] > 0), times * np.radians(reference_deg.astype("float64"))
    return xr.Dataset({
        "cosine": (cosine * np.cos(turn) + sine * np.sin(turn)) / total,
        "sine": (sine * np.cos(turn) - cosine * np.sin(turn)) / total,
    })  # fmt: skip
