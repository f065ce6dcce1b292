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
def enter_axis(place, u, t, per_length, width, count):
    """Return what a walk keeps of one axis, and its cell at distance t.

    place: the ray's origin from the lower face; u: its direction; width: that of a cell, per_length: the
    reciprocal.
    """
    u, inverse = component_and_reciprocal(u)
    number = number_along(place + t * u, per_length, count)
    up, last = 1 if u > 0.0 else 0, count - 1 if u > 0.0 else (0 if u < 0.0 else number)
    return (place, width, inverse, up, last), number


@device
def next_face(axis, number):
    """Return the distance at which the ray leaves a cell along an axis; infinity from the last one."""
    place, width, inverse, up, last = axis
    return (width * (number + up) - place) * inverse if number != last else math.inf


@device
def beyond_face(axis, number):
    """Return the number of the next cell along an axis."""
    return number + 2 * axis[3] - 1


@device
def enter_cells(place, direction, t, per_length, width, count):
    """Return what a walk keeps of the axes, its cell at distance t, and the distances of the next faces.

    All arguments but t have one number per axis.
    """
    x, i = enter_axis(place[0], direction[0], t, per_length[0], width[0], count[0])
    y, j = enter_axis(place[1], direction[1], t, per_length[1], width[1], count[1])
    z, m = enter_axis(place[2], direction[2], t, per_length[2], width[2], count[2])
    return (x, y, z), (i, j, m), (next_face(x, i), next_face(y, j), next_face(z, m))


@device
def nearest_face(faces):
    """Return the distance at which a walk leaves its cell."""
    return min(faces[0], min(faces[1], faces[2]))


@device
def next_cell(axes, cell, faces):
    """Return the cell behind the nearest face, and the distances of the next faces."""
    (x, y, z), (i, j, m), (t_x, t_y, t_z), nearest = axes, cell, faces, nearest_face(faces)
    if nearest == t_x:
        i = beyond_face(x, i)
        t_x = next_face(x, i)
    elif nearest == t_y:
        j = beyond_face(y, j)
        t_y = next_face(y, j)
    else:
        m = beyond_face(z, m)
        t_z = next_face(z, m)
    return (i, j, m), (t_x, t_y, t_z)
