"""Rows of acting surfaces: the material of each part and each side, with its optical properties."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.quantile_tables import Quantile, constant_quantile, quantile_row
from transport.materials import (
    Black,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    Mirror,
    Mixture,
    ThinLens,
    Transparent,
    TwoSided,
)
from transport.sheets import Member
from transport.speeds import SpeedDistribution
from transport.theory.microfacets import lobe_quantile
from transport.validation import SceneError, shown

if TYPE_CHECKING:
    from transport.compile.plan import Plan

Rows = list[tuple[np.ndarray, np.ndarray]]  # rows of layout.SURFACE and layout.OPTICS


def nothing() -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of a transparent surface."""
    surface = layout.row(layout.SURFACE, material=layout.TRANSPARENT, albedo=1.0)
    return surface, layout.row(layout.OPTICS, side=1.0, ratio=1.0)


def coat_rows(plan: Plan, member: Member) -> Rows:
    """Return the rows of an acting member: front, then back where the two differ."""
    material = member.surface.material
    front, back = (material.front, material.back) if isinstance(material, TwoSided) else (material, None)
    rows = _part_rows(plan, front, member)
    if back is not None:
        rows[0][0]["back"] = len(rows)
        rows += _part_rows(plan, back, member)
    return rows


def _part_rows(plan: Plan, material: Material, member: Member) -> Rows:
    """Return one row per part of a mixture, with cumulative shares; one row for any other material."""
    if not isinstance(material, Mixture):
        return [_rows(plan, material, member)]
    shares = np.cumsum([share for _, share in material.parts])
    rows = [_rows(plan, part, member) for part, _ in material.parts]
    for (surface, _), share in zip(rows, shares, strict=True):
        surface["share"], surface["parts"] = share, len(rows)
    return rows


def _rows(plan: Plan, material: Material, member: Member) -> tuple[np.ndarray, np.ndarray]:
    surface, optics = nothing()
    optics["side"] = member.orientation
    match material:
        case Transparent():
            pass
        case Black() | Diffuse(albedo=0.0, transmission=0.0) | Mirror(reflectance=0.0, transmission=0.0):
            surface["material"], surface["albedo"] = layout.BLACK, 0.0
        case Diffuse(albedo=share, transmission=passed, speed=speed):
            surface["material"], surface["albedo"] = layout.DIFFUSE, share + passed
            optics["through"] = passed / (share + passed)
            if speed is not None and plan.has_speeds:
                surface["quantiles"] = _wall_speeds(plan, speed)
        case Mirror(reflectance=share, transmission=passed):
            surface["material"], surface["albedo"] = layout.MIRROR, share + passed
            optics["through"] = passed / (share + passed)
        case Dielectric(index_inside=inside, index_outside=outside):
            surface["material"] = layout.DIELECTRIC
            optics["inside"], optics["outside"] = inside, outside
            optics["ratio"] = inside / outside
            optics["excess"] = (inside - outside) * (inside + outside) / outside / outside
        case Glossy(roughness=roughness, albedo=albedo):
            surface["material"], surface["albedo"] = layout.GLOSSY, albedo
            optics["roughness"] = roughness
            optics["lobe"] = _address(plan, quantile_row(plan, _lobe(roughness), unit=1.0))
        case ThinLens(focal_length=length):
            surface["material"] = layout.LENS
            optics["cx"], optics["cy"], optics["cz"] = plan.space.place(member.shape.center)
            optics["power"] = plan.space.size / length
        case _:
            raise SceneError(f"Surface: the engine does not support {shown(material)}")
    return surface, optics


def _wall_speeds(plan: Plan, speed: float | SpeedDistribution) -> int:
    """Return the address of the quantile table of speeds leaving a wall (weighted by the speed)."""
    quantile = constant_quantile(speed) if isinstance(speed, float) else speed.flux_quantile
    return _address(plan, quantile_row(plan, quantile))


@lru_cache(maxsize=64)
def _lobe(roughness: float) -> Quantile:
    """Return the quantile function of the microfacet lobe's cosine; one object per roughness."""
    return lambda u: lobe_quantile(u, roughness)


def _address(plan: Plan, row: np.ndarray) -> int:
    """Keep a row alive in the plan, and return its address."""
    plan.kept.append(row)
    return row.ctypes.data
