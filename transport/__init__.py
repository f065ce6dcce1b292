"""Monte Carlo transport: photons fly, crossings are counted, n·v·cosθ and radiance come out with error bars."""

from transport.detectors import Detector, Directions, Positions
from transport.emissions import Beam, Gas, Isotropic, Lambertian
from transport.estimates import Estimate, EstimateArray
from transport.materials import Black, Diffuse, Mirror, Surface, Transparent
from transport.results import Result
from transport.scene import Scene
from transport.shapes import Box, Disk, Point, Rectangle, Sphere
from transport.simulate import simulate
from transport.sources import Source
from transport.units import (
    Unit,
    UnitError,
    arcmin,
    arcsec,
    au,
    cm,
    deg,
    km,
    mm,
    mrad,
    nm,
    ns,
    speed_of_light,
    um,
    us,
)
from transport.validation import SceneError

__version__ = "0.1.0"

__all__ = [
    "Beam", "Black", "Box", "Detector", "Diffuse", "Directions", "Disk", "Estimate", "EstimateArray", "Gas",
    "Isotropic", "Lambertian", "Mirror", "Point", "Positions", "Rectangle", "Result", "Scene", "SceneError", "Source",
    "Sphere", "Surface", "Transparent", "Unit", "UnitError", "arcmin", "arcsec", "au", "cm", "deg", "km", "mm", "mrad",
    "nm", "ns", "simulate", "speed_of_light", "um", "us",
]  # fmt: skip
