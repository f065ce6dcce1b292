"""Faults in the exact values that runs are judged by (transport/theory)."""

from tests.mutants.fault import Fault

FRESNEL, ATTENUATION, VIEW = "theory/fresnel.py", "theory/attenuation.py", "theory/view_factors.py"

FAULTS = (
    Fault(
        FRESNEL,
        "return transmittance(cosine, index_ratio) / (1 + reflectance(cosine, index_ratio))",
        "return transmittance(cosine, index_ratio) ** 2",
        "a plate without the reflections between its faces",
        ("theory/test_fresnel",),
    ),
    Fault(
        FRESNEL,
        "* np.square(index_ratio) * radiance",
        "* np.asarray(index_ratio) * radiance",
        "eta for eta^2 in refracted radiance",
        ("theory/test_fresnel",),
    ),
    Fault(
        FRESNEL,
        "return (s + p) / 2\n\n\ndef transmittance",
        "return p\n\n\ndef transmittance",
        "p-polarised light for unpolarised",
        ("theory/test_fresnel",),
    ),
    Fault(
        "theory/effusion.py",
        "return density * speed / 4\n",
        "return density * speed / 2\n",
        "a factor of 2 in what crosses a plane one way",
        ("theory/test_closed_forms",),
    ),
    Fault(
        "theory/effusion.py",
        "return density * speed * np.maximum(mu, 0.0)",
        "return density * speed * np.abs(mu)",
        "a dropped clamp: a stream that lights both sides",
        ("theory/test_closed_forms",),
    ),
    Fault(
        VIEW,
        "shortest = np.hypot(distance, np.subtract(radius_1, radius_2))",
        "shortest = np.hypot(distance, np.add(radius_1, radius_2))",
        "the shortest line between two rims for the longest",
        ("experiments/test_view_factors", "theory/test_closed_forms"),
    ),
    Fault(
        VIEW,
        "perpendicular_rectangles(size[two], size[one], size[3 - one - two])",
        "perpendicular_rectangles(size[one], size[two], size[3 - one - two])",
        "swapped indices of the walls of a box",
        (
            "experiments/test_view_factors",
            "theory/test_closed_forms",
        ),
    ),
    Fault(
        ATTENUATION,
        "return 2 * exponential_integral(3, tau)",
        "return exponential_integral(2, tau)",
        "diffuse light without the cosine's weight",
        ("media/test_attenuation",),
    ),
    Fault(
        "theory/half_space.py",
        "return math.sqrt(3) / (4 * math.pi) * h_function(mu, 1.0)",
        "return 1 / (4 * math.pi) * h_function(mu, 1.0)",
        "Milne's radiance without the root of 3",
        ("theory/test_slabs",),
    ),
    Fault(
        "theory/phases.py",
        "return (mu * (mu * mu + 3) + 4) / 8",
        "return (mu * (mu * mu + 1) + 2) / 4",
        "Rayleigh's distribution of another density",
        ("physics/test_scattering",),
    ),
    Fault(
        "theory/ordinates.py",
        "through = fresnel.transmittance(mu, self.index) / self.index**2",
        "through = fresnel.transmittance(mu, self.index) / self.index",
        "eta for eta^2 in what leaves a layer",
        (
            "theory/test_slabs::test_light_takes_the_same_way_back",
            "theory/test_slabs::test_bins_of_lambertian_light_hold_the_unscattered_light_too",
        ),
    ),
    Fault(
        "theory/solid_angles.py",
        "return math.pi * (radius / np.hypot(distance, radius)) ** 2",
        "return math.pi * (radius / distance) ** 2",
        "a disk taken for a point",
        ("theory/test_closed_forms",),
    ),
    Fault(
        "theory/solid_angles.py",
        "        if low >= 0:\n            kept.append(here)",
        "        kept.append(here)",
        "a polygon that counts behind the plane, too",
        ("experiments/test_panorama::test_a_polygon_counts_as_far_as_it_is_before_the_plane",),
    ),
)
