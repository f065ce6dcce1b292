"""Every wrong object of a scene is refused when it is made, with object, parameter, value and cure."""

import math

import numpy as np
import pytest

import transport as tp
from tests.refusals import BALL, CUBE, DISK, LAMP, WALL, assert_refused

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
SQUARE, ONE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2)]
MESH, TRIANGLE, SLAB = tp.Mesh.box(size=2.0), tp.Triangle(vertices=CORNERS), tp.Slab(thickness=0.5)
CAP, TUBE = tp.Sphere(radius=2, mu_min=0.5), tp.Cylinder(radius=1, height=2)
GAS = tp.Source(CUBE, tp.Gas(1e20, 500))
WARM, DRIFTING = tp.Maxwellian(temperature=300, mass=4.65e-26), tp.Maxwellian(sigma=1, drift=(0, 0, 31))
SIGNED = tp.SpeedTable((-1, 1), (1, 1))
AIR, HYDROGEN = (tp.Maxwellian(temperature=300, mass=mass) for mass in (4.8e-26, 3.3e-27))
OF_HYDROGEN = tp.Surface(CUBE, tp.Diffuse(1.0, speed=HYDROGEN), "wall")
INSTANT, FLASH = tp.Instant(0.5), tp.Isotropic(energy=1)


def square(faces):
    return tp.Mesh(vertices=SQUARE, faces=faces)


# Words that the message must hold: the call that is refused.
ARGUMENTS = {
    "Disk ... radus=1 ... did you mean 'radius'": lambda: tp.Disk(radus=1),
    "Detector 'lid' ... sides=1 ... 'side'": lambda: tp.Detector(DISK, name="lid", sides=1),
    "reflectance=0.5 ... did you mean 'albedo'?": lambda: tp.Diffuse(reflectance=0.5),
    "albedo=0.5 ... did you mean 'reflectance'?": lambda: tp.Mirror(albedo=0.5),
    "center=(0, 0, 1) ... did you mean 'position'?": lambda: tp.Point(center=(0, 0, 1)),
    "did you mean 'center'?": lambda: tp.Disk(radius=1, position=(0, 0, 1)),
    "diameter=2 ... did you mean 'radius' (half of it)?": lambda: tp.Disk(diameter=2),
    "Scene: medium must be a medium ... Medium(absorption ... got 3": lambda: tp.Scene([LAMP], medium=3),
    "Disk takes keywords only: write Disk(radius=...) ... (0, 0, 1)": lambda: tp.Disk((0, 0, 1)),
    "Lambertian ... keywords only ... radiance=... ... 100.0": lambda: tp.Lambertian(100.0),
    "Beam ... direction ... write Beam(power=...) ... 5.0": lambda: tp.Beam((0, 0, 1), 5.0),
    "Directions takes keywords only: write Directions(mu=...) ... 8": lambda: tp.Directions(8),
    "Mirror ... 0.125 ... Mirror(reflectance=...": lambda: tp.Mirror(0.5, 0.25, 0.125),
    "Diffuse ... albedo ... twice ... 0.25": lambda: tp.Diffuse(0.5, albedo=0.25),
    "Rectangle ... height missing ... height=...": lambda: tp.Rectangle(width=1),
    "Source ... emission missing": lambda: tp.Source(DISK),
    "Scene ... sources missing": lambda: tp.Scene(),
}  # fmt: skip

SHAPES = {
    "Disk: radius must be positive and finite, got -1.0": lambda: tp.Disk(radius=-1.0),
    "Sphere: radius ... positive and finite ... nan": lambda: tp.Sphere(radius=math.nan),
    "Disk: radius ... number ... True": lambda: tp.Disk(radius=True),
    "Disk: radius ... number ... '1'": lambda: tp.Disk(radius="1"),
    "Disk: radius ... finite ... 1000": lambda: tp.Disk(radius=10**400),
    "Disk: inner_radius ... below radius 1.0 ... got 1.0": lambda: tp.Disk(radius=1, inner_radius=1),
    "Disk: inner_radius ... zero or positive ... -2": lambda: tp.Disk(radius=1, inner_radius=-2),
    "Rectangle: width ... positive ... got 0": lambda: tp.Rectangle(width=0, height=1),
    "Rectangle: area ... 1e-200 ... unit": lambda: tp.Rectangle(width=1e-200, height=1e-200),
    "Sphere: area ... 1e+200 ... unit": lambda: tp.Sphere(radius=1e200),
    "Box: volume ... 1e-120 ... unit": lambda: tp.Box(size=1e-120),
    "Rectangle: bounds ... finite ... inf ... move center": lambda: tp.Rectangle(center=(1.7976931348623157e308, 0, 0), width=1e300, height=1),
    "Box: size ... one or three ... (1, 2)": lambda: tp.Box(size=(1, 2)),
    "Box: size ... positive ... (1, -2, 1)": lambda: tp.Box(size=(1, -2, 1)),
    "Disk: center ... three finite numbers ... (0, 0)": lambda: tp.Disk(radius=1, center=(0, 0)),
    "Box: center ... finite ... nan": lambda: tp.Box(size=1, center=[0, 0, math.nan]),
    "Point: position ... None": lambda: tp.Point(position=(1, 2, None)),
    "Disk: normal ... not all zero ... (0, 0, 0)": lambda: tp.Disk(radius=1, normal=(0, 0, 0)),
    "Sphere: axis ... finite ... inf": lambda: tp.Sphere(radius=1, axis=(0, 0, math.inf)),
    "Disk: up ... parallel to normal ... (0, 0, -3)": lambda: tp.Disk(radius=1, up=(0, 0, -3)),
    "Rectangle: up ... (0, 0, 0)": lambda: tp.Rectangle(width=1, height=1, up=(0, 0, 0)),
    "Triangle ... keywords only ... vertices=...": lambda: tp.Triangle(CORNERS),
    "Triangle: vertices ... three points": lambda: tp.Triangle(vertices=CORNERS[:2]),
    "Triangle: vertices ... (0, 0)": lambda: tp.Triangle(vertices=((0, 0), (1, 0), (0, 1))),
    "vertices ... nan": lambda: tp.Triangle(vertices=(*CORNERS[:2], (0, 0, math.nan))),
    "must not lie on one line": lambda: tp.Triangle(vertices=CORNERS[:2] + CORNERS[:1]),
    "Triangle: area ... positive and finite ... 1e-200 ... unit": lambda: tp.Triangle(vertices=1e-200 * np.array(CORNERS)),
    "Triangle: area ... positive and finite ... 1e+200 ... unit": lambda: tp.Triangle(vertices=1e200 * np.array(CORNERS)),
    "within it ... 0.05 m": lambda: tp.Rectangle(width=1, height=1, hole=tp.Disk(center=(0.3, 0, 0), radius=0.25)),
    "within it": lambda: tp.Rectangle(width=1, height=1, hole=tp.Rectangle(width=0.8, height=0.8, up=(1, 1, 0))),
    "in its plane ... 1e-09": lambda: tp.Rectangle(width=1, height=1, hole=tp.Disk(center=(0, 0, 1e-9), radius=0.2)),
    "in its plane": lambda: tp.Rectangle(width=1, height=1, hole=tp.Disk(normal=(0, 1e-6, 1), radius=0.2)),
    "hole of its own": lambda: tp.Rectangle(width=1, height=1, hole=tp.Disk(radius=0.4, inner_radius=0.2)),
    "hole of its own, got Rectangle(": lambda: tp.Rectangle(width=2, height=2, hole=tp.Rectangle(width=1, height=1, hole=tp.Disk(radius=0.25))),
    "be smaller": lambda: tp.Rectangle(width=1, height=1, hole=tp.Rectangle(width=1, height=1)),
    "a Disk or Rectangle ... got Sphere": lambda: tp.Rectangle(width=1, height=1, hole=tp.Sphere(radius=0.1)),
    "Cylinder: radius must be positive": lambda: tp.Cylinder(radius=0, height=1),
    "Cylinder: axis": lambda: tp.Cylinder(radius=1, height=1, axis=(0, 0, 0)),
    "Cylinder: area must be positive and finite ... change the unit": lambda: tp.Cylinder(radius=1e200, height=1e200),
    "radius and top_radius must not both be 0": lambda: tp.Cone(radius=0, height=1),
    "Cone: top_radius must be zero or positive": lambda: tp.Cone(radius=1, top_radius=-1, height=1),
    "focal_length must be positive": lambda: tp.Paraboloid(radius=1, focal_length=0),
    "inner_radius must be below radius": lambda: tp.Paraboloid(radius=1, inner_radius=1, focal_length=1),
    "mu_min must be below mu_max 0.5": lambda: tp.Sphere(radius=1, mu_min=0.5, mu_max=0.5),
    "mu_max must be a number in [-1, 1], got 1.5": lambda: tp.Sphere(radius=1, mu_max=1.5),
    "mu_min must be a number ... 'half'": lambda: tp.Sphere(radius=1, mu_min="half"),
    "thickness must not vanish": lambda: tp.Slab(center=(0, 0, 1), thickness=1e-17),
    "Slab: thickness must be positive": lambda: tp.Slab(thickness=-1),
    "Plane: normal": lambda: tp.Plane(normal=(0, 0, 0)),
}  # fmt: skip

MESHES = {
    "Mesh takes keywords only ... vertices=..., faces=...": lambda: tp.Mesh(SQUARE, ONE),
    "Mesh: faces missing": lambda: tp.Mesh(vertices=SQUARE),
    "vertices must be an array (n, 3) ... [0, 1, 2]": lambda: tp.Mesh(vertices=[0, 1, 2], faces=ONE),
    "vertices ... shape (4, 2)": lambda: tp.Mesh(vertices=np.zeros((4, 2)), faces=ONE),
    "vertices ... 'cube.stl'": lambda: tp.Mesh(vertices="cube.stl", faces=ONE),
    "vertices ... complex128": lambda: tp.Mesh(vertices=np.zeros((4, 3), complex), faces=ONE),
    "vertices ... bool": lambda: tp.Mesh(vertices=np.ones((4, 3), bool), faces=ONE),
    "Mesh: vertices must be finite ... 1 of 5, first vertex 4: [0.0, nan, 0.0] ... correct": lambda: tp.Mesh(vertices=[*SQUARE, (0, math.nan, 0)], faces=ONE),
    "1 of 4, first vertex 3 ... inf": lambda: tp.Mesh(vertices=[*SQUARE[:3], (0, 0, math.inf)], faces=ONE),
    "farther apart ... change the unit": lambda: tp.Mesh(vertices=np.array(SQUARE) * 1e308, faces=ONE),
    "areas ... change the unit": lambda: tp.Mesh(vertices=np.array(SQUARE) * 1e-165, faces=ONE),
    "faces must hold at least one triangle ... got none of 4": lambda: square([]),
    "array (m, 3) ... (0, 1, 2, 3) ... triangulate": lambda: square([(0, 1, 2, 3)]),
    "faces must be whole numbers ... 1 triangles, first triangle 1: [0.0, 1.5, 2.0] ... cast": lambda: square([(0, 1, 2), (0, 1.5, 2)]),
    "faces must be an array ... bool": lambda: square(np.ones((1, 3), bool)),
    "0 to 3 with 4 vertices ... [0, 1, -1]": lambda: square([(0, 1, -1)]),
    "0 to 3 with 4 vertices ... 2 of 3 triangles ... triangle 1: [0, 1, 7], triangle 2: [8, 1, 2]": lambda: square([(0, 1, 2), (0, 1, 7), (8, 1, 2)]),
    "triangle 1: [1, 3, 4] ... subtract 1": lambda: square([(1, 2, 3), (1, 3, 4)]),
    "three different vertices ... 1 of 2, first triangle 1: [3, 1, 3] ... leave": lambda: square([(0, 1, 2), (3, 1, 3)]),
    "same three vertices twice ... 1 that repeat ... triangles 0 and 2: [2, 0, 1] ... leave the copies out": lambda: square([(0, 1, 2), (0, 2, 3), (2, 0, 1)]),
    "triangles must have an area ... 1 of 2, first triangle 1: [[0.0, 0.0, 0.0] ... move or merge": lambda: tp.Mesh(vertices=[*SQUARE, (0.5, 0.5, 0)], faces=[(0, 1, 2), (0, 2, 4)]),
    "triangles must have an area": lambda: tp.Mesh(vertices=[(0.1, 0.2, 0.3), (0.2, 0.4, 0.6), (0.7, 1.4, 2.1)], faces=ONE),
    "must have an area ... 8 of 12": lambda: tp.Mesh.box(size=(1, 1, 1e-30)),
    "by must be three finite lengths ... got 1": lambda: MESH.moved(1),
    "Mesh: triangles must have an area": lambda: MESH.moved((1e17, 0, 0)),
    "by must be a number, positive and finite, got 0": lambda: MESH.scaled(0),
    "tolerance must be a length in metres ... -0.001": lambda: MESH.merged(-1e-3),
    "Mesh.sphere: triangles must be a whole number from 1 to 20000000, got 0": lambda: tp.Mesh.sphere(radius=1, triangles=0),
    "size ... (1, 0, 1)": lambda: tp.Mesh.box(size=(1, 0, 1)),
    "point must be three finite numbers ... (1, 2)": lambda: MESH.holds((1, 2)),
}  # fmt: skip

MATERIALS = {
    "Diffuse: albedo must be in [0, 1], got 1.5": lambda: tp.Diffuse(1.5),
    "Diffuse: albedo ... nan": lambda: tp.Diffuse(math.nan),
    "Mirror: reflectance ... [0, 1] ... -0.1": lambda: tp.Mirror(-0.1),
    "Surface: shape ... 'floor'": lambda: tp.Surface("floor", tp.Black()),
    "Surface 'p': shape ... Point ... sources only": lambda: tp.Surface(tp.Point(), tp.Black(), name="p"),
    "Surface: material ... an instance ... Black": lambda: tp.Surface(DISK, tp.Black),
    "Surface: name ... not empty ... ''": lambda: tp.Surface(DISK, tp.Black(), name=""),
    "Surface 'a.b': name ... 'a_b'": lambda: tp.Surface(DISK, tp.Black(), name="a.b"),
    "Surface: shape ... Cloud( ... sources only": lambda: tp.Surface(tp.Cloud(sigma=1), tp.Black()),
    "Diffuse: speed ... positive ... got 0": lambda: tp.Diffuse(1, speed=0),
    "Diffuse: speed ... gas at rest ... drift": lambda: tp.Diffuse(1, speed=DRIFTING),
    "Diffuse: speed ... negative ... SpeedTable": lambda: tp.Diffuse(1, speed=SIGNED),
    "Diffuse ... without a keyword ... speed=... ... got 5": lambda: tp.Diffuse(1, 0, 5),
    "Mixture: shares ... add up to 1 ... 0.5 ... Black()": lambda: tp.Mixture({tp.Mirror(): 0.5}),
    "Mixture: the share of Mirror ... [0, 1] ... -1": lambda: tp.Mixture({tp.Mirror(): -1, tp.Black(): 2}),
    "Mixture: parts ... with their shares ... [1.0]": lambda: tp.Mixture([1.0]),
    "Mixture: parts ... Mirror() ... got 3": lambda: tp.Mixture({3: 1}),
    "Mixture: parts ... differ ... add up their shares": lambda: tp.Mixture([(tp.Black(), 0.5)] * 2),
    "Mixture: parts ... another Mixture ... list its parts": lambda: tp.Mixture({tp.Mixture({tp.Black(): 1}): 1}),
}  # fmt: skip

SPEEDS = {
    "Maxwellian ... temperature and mass, or sigma ... neither": lambda: tp.Maxwellian(),
    "Maxwellian: mass ... 300.0 ... write mass=": lambda: tp.Maxwellian(temperature=300),
    "Maxwellian: temperature ... positive ... got 0": lambda: tp.Maxwellian(temperature=0, mass=1),
    "Maxwellian: drift ... (1, 2)": lambda: tp.Maxwellian(sigma=1, drift=(1, 2)),
    "Maxwellian: sigma ... 643.5 ... got 5 ... leave it out": lambda: tp.Maxwellian(temperature=300, mass=1e-26, sigma=5),
    "Maxwellian ... sigma=1e+308 ... unit": lambda: tp.Maxwellian(sigma=1e308),
    "Maxwellian ... keywords only ... 300": lambda: tp.Maxwellian(300),
    "Maxwellian: drift ... 30 sigma ... 100000 m/s": lambda: WARM.one_way_flux(1e5),
    "SpeedTable: speeds ... increasing ... 1.0 after 1.0": lambda: tp.SpeedTable((0, 1, 1), (1, 1, 1)),
    "SpeedTable: speeds ... two finite numbers ... (1,)": lambda: tp.SpeedTable((1,), (1,)),
    "SpeedTable: density ... zero or positive ... -1.0": lambda: tp.SpeedTable((0, 1), (1, -1)),
    "SpeedTable: density ... not all zero ... (0.0, 0.0)": lambda: tp.SpeedTable((0, 1), (0, 0)),
    "SpeedTable: density ... as many ... 2, got 3": lambda: tp.SpeedTable((0, 1), (1, 2, 3)),
    "SpeedTable: speeds ... finite range ... 1e+308": lambda: tp.SpeedTable((-1e308, 1e308), (1, 1)),
    "InverseCDF: quantile ... function ... got 3": lambda: tp.InverseCDF(3),
    "InverseCDF: quantile ... array ... TypeError ... NumPy": lambda: tp.InverseCDF(math.sqrt),
    "InverseCDF: quantile ... ValueError": lambda: tp.InverseCDF(lambda u: 1 if u < 0.5 else 2),
    "InverseCDF: quantile ... shape () ... NumPy": lambda: tp.InverseCDF(lambda u: 3.0),
    "InverseCDF: quantile ... inf at u = 0.0 ... 2**-54": lambda: tp.InverseCDF(lambda u: 1 / u),
    "InverseCDF: quantile ... not fall ... u = ": lambda: tp.InverseCDF(lambda u: 1 - u),
    "InverseCDF: quantile ... Gas(speed=0)": lambda: tp.InverseCDF(lambda u: 0 * u),
}  # fmt: skip

EMISSIONS = {
    "Lambertian ... exactly one of radiance, exitance, power ... none": lambda: tp.Lambertian(),
    "Isotropic ... exactly one ... power=1, intensity=2": lambda: tp.Isotropic(power=1, intensity=2),
    "Lambertian: radiance ... positive ... got 0": lambda: tp.Lambertian(radiance=0),
    "Beam: power ... positive ... -5": lambda: tp.Beam((0, 0, 1), power=-5),
    "Beam: direction ... not all zero ... (0, 0, 0)": lambda: tp.Beam((0, 0, 0), power=5),
    "Isotropic: speed ... positive ... got 0": lambda: tp.Isotropic(power=1, speed=0),
    "Gas: density ... positive ... -1": lambda: tp.Gas(-1, 500),
    "Gas: speed missing ... Gas(speed=...)": lambda: tp.Gas(1e20),
    "Gas ... exactly one of density, number ... none": lambda: tp.Gas(speed=1),
    "Gas ... exactly one ... density=1, number=2": lambda: tp.Gas(1, 500, number=2),
    "exactly one of density, exitance, number": lambda: tp.Effusive(1, 5, exitance=2),
    "Effusive: speed ... positive ... got 0": lambda: tp.Effusive(1, 0),
    "Effusive: speed ... negative ... SpeedTable": lambda: tp.Effusive(1, SIGNED),
    "Gas: speed ... negative ... direction=...": lambda: tp.Gas(1, SIGNED),
    "Gas: speed ... zero or positive ... -5": lambda: tp.Gas(1, -5),
    "Gas: direction ... drift ... Maxwellian": lambda: tp.Gas(1, DRIFTING, direction=(0, 0, 1)),
    "Gas: mass ... 4.65e-26 ... got 1 ... leave it out": lambda: tp.Gas(1, WARM, mass=1),
    "Lambertian: speed ... Maxwellian ... Effusive": lambda: tp.Lambertian(power=1, speed=WARM),
    "Beam: speed ... SpeedTable ... Gas": lambda: tp.Beam((0, 0, 1), power=1, speed=SIGNED),
}  # fmt: skip

SOURCES = {
    "Source: shape ... got 3": lambda: tp.Source(3, tp.Lambertian(power=1)),
    "Source: emission ... Lambertian(radiance=...)": lambda: tp.Source(DISK, tp.Lambertian),
    "Source ... Lambertian ... Point( ... Isotropic": lambda: tp.Source(tp.Point(), tp.Lambertian(power=1)),
    "Source ... Isotropic ... Disk( ... Lambertian": lambda: tp.Source(DISK, tp.Isotropic(power=1)),
    "Source ... Gas leaves from a Box ... Disk(": lambda: tp.Source(DISK, tp.Gas(1, 1)),
    "Source: side ... 'bak' ... did you mean 'back'": lambda: tp.Source(DISK, tp.Lambertian(power=1), side="bak"),
    "Source: side ... 'inside' ... 'back'": lambda: tp.Source(DISK, tp.Lambertian(power=1), side="inside"),
    "Source: side ... 'front'": lambda: tp.Source(DISK, tp.Lambertian(power=1), side="outside"),
    "Source: side ... Gas ... 'back' ... leave it out": lambda: tp.Source(CUBE, tp.Gas(1, 1), side="back"),
    "Source: side ... Point": lambda: tp.Source(tp.Point(), tp.Beam((0, 0, 1), power=1), side="back"),
    "Source: aim ... a shape ... 'lid'": lambda: tp.Source(DISK, tp.Lambertian(power=1), aim="lid"),
    "Source: aim ... Point(": lambda: tp.Source(DISK, tp.Lambertian(power=1), aim=tp.Point()),
    "Source: aim ... Beam ... drop aim": lambda: tp.Source(DISK, tp.Beam((0, 0, 1), power=1), aim=BALL),
    "Source: aim ... Gas ... drop aim": lambda: tp.Source(CUBE, tp.Gas(1, 1), aim=BALL),
    "Source: irradiance ... 7.0 ... write power=": lambda: tp.Source(tp.Point(), tp.Beam((0, 0, 1), irradiance=7)),
    "Source: direction ... -1.0 ... side='back'": lambda: tp.Source(DISK, tp.Beam((0, 0, -1), power=1)),
    "Source: direction ... (0.0, 0.0, 1.0) ... side='front'": lambda: tp.Source(DISK, tp.Beam((0, 0, 1), power=1), side="back"),
    "Source: direction ... plane of the Disk ... (1.0, 0.0 ... tilt": lambda: tp.Source(DISK, tp.Beam((1, 0, math.cos(math.pi / 2)), power=1)),
    "Source: power ... finite ... inf": lambda: tp.Source(BALL, tp.Lambertian(radiance=1e308)),
    "Source: density ... Point ... number=": lambda: tp.Source(tp.Point(), tp.Gas(1, 1)),
    "Source: density ... Cloud ... number=": lambda: tp.Source(tp.Cloud(sigma=(0, 1, 1)), tp.Gas(1, 1)),
    "Isotropic leaves from ... Cloud(": lambda: tp.Source(tp.Cloud(sigma=1), tp.Isotropic(power=1)),
    "Effusive leaves from ... Point( ... Gas": lambda: tp.Source(tp.Point(), tp.Effusive(1, 5)),
    "Source: drift ... flat ... 31.0 ... Sphere": lambda: tp.Source(BALL, tp.Effusive(1, DRIFTING)),
    "Source: drift ... flat ... Box": lambda: tp.Source(CUBE, tp.Effusive(1, DRIFTING)),
    "Maxwellian: drift ... 30 sigma ... 31 m/s": lambda: tp.Source(DISK, tp.Effusive(1, DRIFTING)),
    "Source ... Gas leaves from a Box ... Triangle( ... enclose it in a Box": lambda: tp.Source(TRIANGLE, tp.Gas(1, 1)),
    "Source: aim ... drift ... leave one of them out": lambda: tp.Source(DISK, tp.Effusive(1, tp.Maxwellian(sigma=1, drift=(1, 0, 0))), aim=BALL),
    "Source: aim ... Cloud(": lambda: tp.Source(DISK, tp.Lambertian(power=1), aim=tp.Cloud(sigma=1)),
    "Source: pulse ... a pulse such as ... got 0.5": lambda: tp.Source(tp.Point(), FLASH, pulse=0.5),
    "Source: pulse ... Gas ... drop it": lambda: tp.Source(CUBE, tp.Gas(1, 1), pulse=INSTANT),
    "Source: pulse Instant ... energy=... ... power=5.0 ... BoxPulse": lambda: tp.Source(tp.Point(), tp.Isotropic(power=5), pulse=INSTANT),
    "Source: pulse GaussianPulse ... number=... ... density=1.0": lambda: tp.Source(DISK, tp.Effusive(1, 5), pulse=tp.GaussianPulse(9, 1)),
    "Scene: duration ... Isotropic(energy=...) ... None ... duration=...": lambda: tp.Source(tp.Point(), FLASH).check_clock(None),
    "Scene: duration ... Effusive(number=...)": lambda: tp.Source(DISK, tp.Effusive(number=1, speed=5)).check_clock(None),
    "Scene: duration ... a Gas ... None": lambda: GAS.check_clock(None),
    "Scene: duration ... BoxPulse( ... None": lambda: tp.Source(tp.Point(), tp.Isotropic(power=1), pulse=tp.BoxPulse(0, 1)).check_clock(None),
    "Source: pulse ... 0.5 s ... Instant ... longer": lambda: tp.Source(tp.Point(), FLASH, pulse=INSTANT).check_clock(0.5),
    "Source: pulse ... 0.75 s ... from 0 to 1 s": lambda: tp.Source(tp.Point(), FLASH, pulse=tp.BoxPulse(0, 1)).check_clock(0.75),
    "Source: pulse ... 1.5 s ... to 1.85 s": lambda: tp.Source(tp.Point(), FLASH, pulse=tp.GaussianPulse(1, 0.1)).check_clock(1.5),
    "Instant: time ... zero or positive ... -1": lambda: tp.Instant(-1),
    "BoxPulse: stop ... after start=2.0 ... got 1.0": lambda: tp.BoxPulse(2, 1),
    "GaussianPulse: time ... 8.5 sigma ... got 1.0 ... time=8.5": lambda: tp.GaussianPulse(1, 1),
    "Cloud: sigma ... not all 0 ... Point": lambda: tp.Cloud(sigma=(0, 0, 0)),
    "Cloud: sigma ... one or three ... (1, 2)": lambda: tp.Cloud(sigma=(1, 2)),
    "leaves from a ... area is infinite; use a large Rect": lambda: tp.Source(tp.Plane(), tp.Lambertian(power=1)),
    "Gas ... Slab ... is infinite": lambda: tp.Source(SLAB, tp.Gas(density=1, speed=1)),
    "aim must be finite, got Plane": lambda: tp.Source(tp.Point(), tp.Isotropic(power=1), aim=tp.Plane()),
    "Gas leaves from ... a zone; leave out mu_min and mu_max": lambda: tp.Source(CAP, tp.Gas(density=1, speed=1)),
    "Beam leaves from a Point, ... got shape=Cylinder": lambda: tp.Source(TUBE, tp.Beam((0, 0, 1), power=1)),
    "Gas leaves from a Box ... ; enclose it in a Box": lambda: tp.Source(TUBE, tp.Gas(density=1, speed=1)),
    "write side='back'": lambda: tp.Source(TUBE, tp.Lambertian(power=1), side="inside"),
    "Source:  ... leaves from a  ... got shape=Triangle": lambda: tp.Source(TRIANGLE, tp.Isotropic(power=1)),
    "aim must not lie in the source's own plane": lambda: tp.Scene(tp.Source(DISK, tp.Lambertian(power=1), aim=DISK)),
    "aim must not lie in the source's own plane, got Triangle": lambda: tp.Scene(tp.Source(tp.Disk(center=(5, 0, 0), radius=1), tp.Lambertian(power=1), aim=TRIANGLE)),
}  # fmt: skip

SCENES = {
    "Scene: sources ... at least one ... none": lambda: tp.Scene([]),
    "Scene: sources ... Source ... Detector 'floor' ... sources[0]": lambda: tp.Scene([tp.Detector("floor")]),
    "Scene: surfaces ... Source(": lambda: tp.Scene(LAMP, LAMP),
    "Scene: detectors ... Disk( ... detectors[0]": lambda: tp.Scene(LAMP, (), [DISK]),
    "got Detector 'floor' as surfaces[0]; it belongs into detectors=[...]: the order is sources, surfaces, detectors": lambda: tp.Scene(LAMP, [tp.Detector("floor")], [WALL]),
    "got Surface 'floor' as detectors[0]; it belongs into surfaces=[...]": lambda: tp.Scene(LAMP, detectors=WALL),
    "Scene: sources ... 'lamp'": lambda: tp.Scene("lamp"),
    "Scene: duration ... positive ... -1": lambda: tp.Scene(LAMP, duration=-1),
    "Scene: duration ... Gas ... None ... duration=...": lambda: tp.Scene(GAS),
    "Scene: sources ... watts ... particles ... Gas, Lambertian": lambda: tp.Scene([GAS, LAMP], duration=1),
    "Scene: name ... unique ... 'floor'": lambda: tp.Scene(LAMP, [WALL, WALL]),
    "Scene: name ... unique ... 2 Detectors 'floor' ... name=": lambda: tp.Scene(LAMP, WALL, [tp.Detector("floor"), tp.Detector("floor", side="back")]),
    "Detector 'floor': name ... surface ... rename": lambda: tp.Scene(LAMP, WALL, tp.Detector(BALL, name="floor")),
    "Detector 'flor': shape ... got 'flor' ... did you mean 'floor'": lambda: tp.Scene(LAMP, WALL, tp.Detector("flor")),
    "Source: shape ... got 'lid' ... 'floor'": lambda: tp.Scene(tp.Source("lid", tp.Lambertian(power=1)), WALL),
    "Scene: name ... got 'roof' ... 'floor'": lambda: tp.Scene(LAMP, WALL).surface("roof"),
    "Source ... Isotropic ... Disk(": lambda: tp.Scene(tp.Source("floor", tp.Isotropic(power=1)), WALL),
    "Detector 'floor': side": lambda: tp.Scene(LAMP, WALL, tp.Detector("floor", side="inside")),
    "Detector 'floor' ... Positions: u ... (0.0, 2.0)": lambda: tp.Scene(LAMP, WALL, tp.Detector("floor", positions=tp.Positions(u=(0, 2)))),
    "'wall': its Maxwellian is of particles of 3.3e-27 kg, got 4.8e-26 kg": lambda: tp.Scene(tp.Source(CUBE, tp.Gas(1e10, AIR)), OF_HYDROGEN, duration=1),
    "'wall': a wall with a speed needs a scene of particles, got watts": lambda: tp.Scene(tp.Source(CUBE, tp.Isotropic(power=1)), OF_HYDROGEN),
}  # fmt: skip

TABLES = (ARGUMENTS, SHAPES, MESHES, MATERIALS, SPEEDS, EMISSIONS, SOURCES, SCENES)


@pytest.mark.slow
@pytest.mark.parametrize(("words", "make"), [case for table in TABLES for case in table.items()])
def test_wrong_input_is_refused_with_object_parameter_value_and_cure(words, make):
    assert_refused(make, words)


def test_masked_vertices_are_refused_because_a_fill_value_is_no_coordinate():
    masked = np.ma.masked_greater(np.array(SQUARE), 0.5)
    assert_refused(
        lambda: tp.Mesh(vertices=masked, faces=ONE),
        "vertices must have all their values, got 4 masked; write .filled(0)",
    )


def test_a_refusal_is_a_value_error():
    assert issubclass(tp.SceneError, ValueError)
