"""A smooth boundary of air and glass: radiance by direction on both sides, and shares of beams by angle."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence

import numpy as np

from transport import Estimate, EstimateArray
from transport.theory import fresnel
from transport.viz.lobes import Lobe, Panel, lobes
from transport.viz.shares import Shares, Sheet, shares

TITLES = {"sky": "Light from the air: L' = (1 − R) n² L", "glow": "Light from the glass: L = (1 − R) L'/n²"}
LABEL = r"radiance  [$\mathrm{W\,m^{-2}\,sr^{-1}}$]"


def lobes_of_boundary(
    leaving: Mapping[str, tuple[EstimateArray, EstimateArray]],
    index: float,
    radiance: float,
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw what leaves a boundary on both sides of equal radiance from one; returns the path.

    leaving: "sky" (light from the air) or "glow" (from the glass) -> radiance that leaves in air and in glass by polar
    angle from the normal, all azimuths in one bin: left and right show the same.  radiance: that arrives [W m^-2 sr^-1].
    """
    panels = {TITLES[show]: _panel(show, *sides, index, radiance) for show, sides in leaving.items()}
    return lobes(panels, path, LABEL, title, note)


def shares_by_angle(
    fans: Mapping[str, Sequence[Estimate]],
    angles: Mapping[str, np.ndarray],
    plates: Mapping[float, Estimate],
    index: float,
    path: str | os.PathLike,
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw what one boundary reflects and what a plate lets through by angle; returns the path.

    fans, angles: "air" or "glass" -> shares reflected of beams from there, and their angles [rad].
    plates: angle [rad] -> share let through.
    """
    sheets = {}
    if fans:
        series = [
            Shares(f"from {side}", np.degrees(angles[side]), estimates, _reflected(side, index))
            for side, estimates in fans.items()
        ]
        sheets["Reflected by one boundary"] = Sheet("share reflected, R", series, _polarised(index))
    if plates:
        passed = Shares(
            "(1 − R)/(1 + R)", np.degrees(list(plates)), list(plates.values()), _passed(index, False)
        )
        guides = {"if it stayed polarised": _passed(index, True)}
        sheets["Let through by a plate"] = Sheet("share let through", [passed], guides)
    return shares(sheets, path, title, note)


def _panel(show: str, air: EstimateArray, glass: EstimateArray, index: float, radiance: float) -> Panel:
    from_air = show == "sky"
    critical = float(fresnel.critical_angle(1 / index))

    def in_air(angle: np.ndarray) -> np.ndarray:
        reflected = fresnel.reflectance(np.abs(np.cos(angle)), index)
        return radiance * (reflected if from_air else (1 - reflected) / index**2)

    def in_glass(angle: np.ndarray) -> np.ndarray:
        reflected = fresnel.reflectance(np.abs(np.cos(angle)), 1 / index)
        return radiance * ((1 - reflected) * index**2 if from_air else reflected)

    names = ("reflected", "let through") if from_air else ("let through", "reflected")
    found = [_mirrored(names[0], air, 0.0, in_air), _mirrored(names[1], glass, math.pi, in_glass)]
    rays = {math.pi + sign * critical: f"{math.degrees(critical):.1f}°" for sign in (-1, 1)}
    low = -math.pi / 2 if from_air else math.pi / 2
    arc = (f"L = {radiance:g} that arrives", radiance, low, low + math.pi)
    media = ("air", f"glass,\nn = {index:.4g}")
    return Panel(sorted(found, key=lambda lobe: lobe.label), rays, media=media, arc=arc)


def _mirrored(label: str, radiance: EstimateArray, middle: float, exact) -> Lobe:
    """To the left and to the right of a normal at the angle `middle`."""
    edges = radiance.coords["theta"]
    value, error = (np.concatenate([part[::-1], part]) for part in (radiance.value, radiance.error))
    return Lobe(label, middle + np.concatenate([-edges[:0:-1], edges]), value, error, exact)


def _reflected(side: str, index: float):
    ratio = index if side == "air" else 1 / index
    return lambda degrees: fresnel.reflectance(np.cos(np.radians(degrees)), ratio)


def _polarised(index: float):
    """Both polarisations from air, of which R is the mean."""

    def share(degrees: np.ndarray, which: str) -> np.ndarray:
        return getattr(fresnel.reflectances(np.cos(np.radians(degrees)), index), which)

    return {
        f"from air, R{name}": lambda d, which=which: share(d, which)
        for name, which in (("ₛ", "s"), ("ₚ", "p"))
    }


def _passed(index: float, keeps: bool):
    return lambda degrees: fresnel.plate_transmittance(np.cos(np.radians(degrees)), index, keeps)
