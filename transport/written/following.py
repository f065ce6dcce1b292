"""Derived fields: they follow from an object's other fields, so a file omits them."""

from transport.detectors import Detector
from transport.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.materials import Surface
from transport.speeds import Maxwellian
from transport.units import speed_of_light
from transport.volumes import VolumeDetector


def following(part: object) -> tuple[str, ...]:
    """Return the names of the fields that have the same value if omitted."""
    match part:
        case Surface():
            return ("front", "back") if part.shape.is_closed else ("outside", "inside")
        case Maxwellian(temperature=float()):
            return ("sigma",)
        case Gas(speed=Maxwellian(mass=mass)) | Effusive(speed=Maxwellian(mass=mass)) if part.mass == mass:
            return ("mass",)
        case Detector() | VolumeDetector() if part.name == part.shape:
            return ("name",)
        case Beam() | Isotropic() | Lambertian() if part.speed == speed_of_light:
            return ("speed",)
    return ()
