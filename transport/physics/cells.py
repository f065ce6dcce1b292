"""Walk of a ray through cells of equal size, from face to face (Amanatides and Woo 1987).

The distance of a face is computed from its number, so that rounding does not accumulate. There is no face
beyond the last cells: a ray ends in them wherever rounding puts its end, and every step makes progress.
"""

import math

from numba import int64

from transport.physics.device import device

# a ray with a direction component below MIN_COMPONENT never leaves a cell; NO_CROSSING is its reciprocal
MIN_COMPONENT, NO_CROSSING = 1e-280, 1e300


@device
def component_and_reciprocal(v):
    """Return a direction component in cells per scene length and its reciprocal.

    The component is 0, and the reciprocal NO_CROSSING, if the ray never leaves a cell along this axis.
    """
    moves = abs(v) > MIN_COMPONENT
    return v if moves else 0.0, 1.0 / v if moves else NO_CROSSING


@device
def number_along(place, per_length, count):
    """Return the cell along one axis that holds a coordinate measured from the lower face, clamped."""
    number = int64(math.floor(place * per_length))
    return 0 if number < 0 else (count - 1 if number >= count else number)


@device
def enter_axis(place, u, t, per_length, width, count, stride):
    """Return what a walk keeps of one axis, its cell at distance t, and the face through which it leaves it.

    place: the ray's origin from the lower face; u: its direction; width: that of a cell, per_length: the
    reciprocal; stride: the difference of the numbers of neighbours along this axis. Faces count from 0.
    """
    u, inverse = component_and_reciprocal(u)
    number = number_along(place + t * u, per_length, count)
    face = number + (1.0 if u > 0.0 else 0.0)
    last = count * 1.0 if u > 0.0 else (0.0 if u < 0.0 else face)
    step, stride = (1.0, stride) if u > 0.0 else (-1.0, -stride)
    return (place, width, inverse, last, step, stride), number, face


@device
def distance_of_face(axis, face):
    """Return the distance at which the ray meets a face across an axis; infinity at the last one."""
    place, width, inverse, last, _, _ = axis
    there = width * face
    return (there - place) * inverse if face != last else math.inf


@device
def enter_cells(place, direction, t, per_length, width, count):
    """Return what a walk keeps of the axes, its cell at distance t, and the distances of the next faces.

    All arguments but t have one number per axis. Cells are numbered row by row; a walk keeps its cell as this
    number and the next face across each axis.
    """
    x, i, f = enter_axis(place[0], direction[0], t, per_length[0], width[0], count[0], count[1] * count[2])
    y, j, g = enter_axis(place[1], direction[1], t, per_length[1], width[1], count[1], count[2])
    z, m, h = enter_axis(place[2], direction[2], t, per_length[2], width[2], count[2], 1)
    cell = (i * count[1] + j) * count[2] + m, f, g, h
    return (x, y, z), cell, (distance_of_face(x, f), distance_of_face(y, g), distance_of_face(z, h))


@device
def nearest_face(faces):
    """Return the distance at which a walk leaves its cell."""
    return min(faces[0], min(faces[1], faces[2]))


@device
def next_cell(axes, cell, faces):
    """Return the cell behind the nearest face, and the distances of the next faces."""
    (x, y, z), (number, f, g, h), (t_x, t_y, t_z), nearest = axes, cell, faces, nearest_face(faces)
    if nearest == t_x:
        number, f = number + x[5], f + x[4]
        t_x = distance_of_face(x, f)
    elif nearest == t_y:
        number, g = number + y[5], g + y[4]
        t_y = distance_of_face(y, g)
    else:
        number, h = number + z[5], h + z[4]
        t_z = distance_of_face(z, h)
    return (number, f, g, h), (t_x, t_y, t_z)
