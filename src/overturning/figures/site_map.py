"""Map of stations, epicentre and fault strike with scale and north arrow (the paper's figure 4)."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.errors import ArgumentError
from overturning.figures.style import DASHED, FALLS, INK, SERIES, caption, grid, labels, line_through_origin
from overturning.statistics.circular import resultant
from overturning.statistics.earthquakes import LEAST_DISTANCE_KM
from overturning.units import EARTH_RADIUS_KM


def local_km(latitude: Any, longitude: Any, latitude0: float, longitude0: float) -> tuple[Any, Any]:
    """East and north of a point, km, on a plane that touches the sphere at the origin (azimuthal equidistant).

    Distance and direction from the origin are those along the great circle.
    """
    north, north0, turn = np.radians(latitude), np.radians(latitude0), np.radians(np.asarray(longitude) - longitude0)
    x = np.cos(north) * np.sin(turn)
    y = np.cos(north0) * np.sin(north) - np.sin(north0) * np.cos(north) * np.cos(turn)
    z = np.sin(north0) * np.sin(north) + np.cos(north0) * np.cos(north) * np.cos(turn)
    # An angle over its sine.
    scale = EARTH_RADIUS_KM / np.sinc(np.arctan2(np.hypot(x, y), z) / np.pi)
    return scale * x, scale * y


def sites_by_earthquake(cube: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return a site for `site_map_figure` for each earthquake with an epicentre and a station, or with two stations.

    Earthquakes are in the order of the cube. The strike is the mean axis of the strikes of the records; the epicentre
    is the first known one.
    """
    names = ("station_latitude", "station_longitude", "epicentre_latitude", "epicentre_longitude", "fault_normal")
    table = {name: cube[name].to_numpy().astype(np.float64) for name in names}
    events, stations = (cube[name].to_numpy().astype(str) for name in ("event", "station"))
    sites = {}
    for event in dict.fromkeys(events.tolist()):
        rows = events == event
        placed = rows & np.isfinite(table["station_latitude"])
        epicentres = np.flatnonzero(rows & np.isfinite(table["epicentre_latitude"]))
        if placed.sum() < (1 if epicentres.size else 2):
            continue
        strikes = table["fault_normal"][rows & np.isfinite(table["fault_normal"])] - 90.0
        site = {name: ("station", table[name][placed]) for name in names[:2]}
        scalars = {name: table[name][epicentres[0]] for name in names[2:4]} if epicentres.size else {}
        scalars["fault_strike"] = resultant(strikes, axial=True)[0]
        sites[event] = xr.Dataset({**site, **scalars}, coords={"station": stations[placed]})
    return sites


def distance_sentences(site: xr.Dataset) -> list[str]:
    """Return a sentence for each station with its distance and direction from the epicentre.

    The direction is left out below `LEAST_DISTANCE_KM`. The list is empty without an epicentre.
    """
    if "epicentre_latitude" not in site:
        return []
    east, north = local_km(
        site["station_latitude"].to_numpy(), site["station_longitude"].to_numpy(),
        float(site["epicentre_latitude"]), float(site["epicentre_longitude"]),
    )  # fmt: skip
    sentences = []
    for name, x, y in zip(site["station"].to_numpy(), east, north, strict=True):
        away, way = float(np.hypot(x, y)), round(float(np.degrees(np.arctan2(x, y)))) % 360
        far, near = (
            f"{away:.0f} km from the epicentre, in the direction {way}°",
            f"less than {LEAST_DISTANCE_KM:g} km from the epicentre",
        )
        sentences.append(f"{name}: {far if away >= LEAST_DISTANCE_KM else near}.")
    return sentences


def _scale_length(extent: float) -> float:
    target = extent / 4
    power = 10.0 ** np.floor(np.log10(target))
    return float(max(step * power for step in (1, 2, 5) if step * power <= target))


def _draw_site_map(axes: Any, site: xr.Dataset) -> None:
    """Draw the map of a site."""

    def scalar(name: str) -> float:
        return float(site[name]) if name in site else float("nan")

    latitude, longitude = site["station_latitude"].to_numpy(), site["station_longitude"].to_numpy()
    known = np.isfinite(latitude) & np.isfinite(longitude)
    if not known.any():
        raise ArgumentError("site: no station has coordinates; give latitude and longitude of at least one")
    epicentre = scalar("epicentre_latitude"), scalar("epicentre_longitude")
    with_epicentre = bool(np.isfinite(epicentre).all())
    origin = epicentre if with_epicentre else (float(latitude[known].mean()), float(longitude[known].mean()))
    east, north = local_km(latitude[known], longitude[known], *origin)
    reach, strike = max(np.abs(east).max(), np.abs(north).max(), 5.0), scalar("fault_strike")
    if with_epicentre:
        axes.plot(0, 0, "*", color=FALLS, markersize=15, markeredgecolor=INK, label="epicentre", zorder=4)
        if np.isfinite(strike):
            look = {"linestyle": DASHED, "linewidth": 2, "label": "strike of the fault"}
            line_through_origin(axes, strike, 0.8 * reach, **look)
    axes.plot(east, north, "^", color=SERIES[2], markersize=9, markeredgecolor=INK, label="station", zorder=5)
    for name, x, y in zip(site["station"].to_numpy()[known], east, north, strict=True):
        axes.annotate(
            str(name), (x, y), (0, -8), textcoords="offset points", ha="center", va="top", fontsize=8, parse_math=False,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}, zorder=6,
        )  # fmt: skip
    extent = 1.35 * reach
    axes.set(xlim=(-extent, extent), ylim=(-extent, extent), aspect="equal")
    labels(axes, "east, km", "north, km")
    axes.spines[:].set_visible(True)
    scale = _scale_length(2 * extent)
    x0, y0 = -0.92 * extent, -0.9 * extent
    axes.plot([x0, x0 + scale], [y0, y0], color=INK, linewidth=3, solid_capstyle="butt")
    axes.annotate(
        f"{scale:g} km", (x0 + scale / 2, y0), (0, 4), textcoords="offset points", ha="center", va="bottom", fontsize=8
    )
    axes.annotate("N", (0.93, 0.85), (0.93, 0.97), xycoords="axes fraction", ha="center", va="top", fontsize=10)
    axes.annotate(
        "", (0.93, 0.91), (0.93, 0.80), xycoords="axes fraction", arrowprops={"arrowstyle": "-|>", "color": INK}
    )


def site_map_figure(site: xr.Dataset, title: str) -> Figure:
    """Draw the map of a site.

    A site has ``station_latitude`` and ``station_longitude`` (degrees) over the dimension ``station``, whose coordinate
    holds the names; and optionally the scalars ``epicentre_latitude``, ``epicentre_longitude`` and ``fault_strike``
    (degrees, NaN if unknown; the strike is drawn through the epicentre). Raises an ArgumentError if no station has
    coordinates.
    """
    figure, panels = grid(1, 1, 4.6, 5.1)
    _draw_site_map(panels[0, 0], site)
    caption(figure, title, panels[0, 0], 3)
    return figure
