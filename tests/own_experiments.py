"""Experiments of one's own, as text for files: a disk and a meter, and what is added or wrong."""

EXPERIMENT = '''
"""A diffuse disk and a small meter on its axis."""
import math
import transport as tp

law = "E = π L sin²θ on the axis of a diffuse disk (Foote 1915)"
question = "How much does a diffuse disk send to a meter on its axis?"
particles = 20_000

def scene(distance=2, radius=0.5):
    meter = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=1e-4)
    source = tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=100.0), aim=meter)
    return tp.Scene(sources=[source], detectors=[tp.Detector(meter, name="meter")])

def measure(result):
    return {"irradiance": result["meter"].irradiance}

def exact(distance=2, radius=0.5):
    return {"irradiance": PI * 100 * radius**2 / (radius**2 + distance**2)}

def verdict(outcomes):
    return "As much as its solid angle, projected, times its radiance."

PI = math.pi
'''
CASES = "\ndef cases():\n    return [{'distance': 2.0}, {'distance': 4.0}]\n"
PICTURE = """
def draw(outcomes, path):
    from matplotlib.figure import Figure
    Figure(figsize=(1, 1)).savefig(path)
"""
UNLIKE_UNITS = (
    "\ndef measure(result):\n    return {'x': result['meter'].irradiance + result['meter'].flux_in}\n"
)
PI_FORGOTTEN = "\nPI = 1.0\n"
