"""Raise ImportError if a user's own file or folder named numpy shadows NumPy.

The package imports this module first, so that the message names the cause.
"""

import numpy

if not hasattr(numpy, "ndarray"):
    raise ImportError(
        f"{getattr(numpy, '__file__', None) or 'a folder called numpy'} shadows NumPy: rename it"
        " (and remove the __pycache__ beside it)"
    )
