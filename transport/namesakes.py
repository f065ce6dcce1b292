"""A file of yours that is called numpy.py hides NumPy from all that is imported beside it: said at once, with the cure."""

import numpy

if not hasattr(numpy, "ndarray"):
    raise ImportError(
        f"{getattr(numpy, '__file__', None) or 'a folder called numpy'} hides NumPy: call it something else"
        " (and remove the __pycache__ beside it)"
    )
