"""Formulas of how snow scatters light, which tests hold the pictures against."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def cornette_shanks(cosine: NDArray[Any] | float, g: float) -> Array:
    """Return p = 3/(8 pi) (1 - g^2) (1 + cos^2) / ((2 + g^2) (1 + g^2 - 2 g cos)^(3/2)) [1/sr].

    For g = 0 it is Rayleigh's; its mean cosine is g (3/5) (4 + g^2) / (2 + g^2).
    Source: Cornette and Shanks 1992, which Nishita et al. 1997 cite.
    """
    c = np.asarray(cosine, np.float64)
    away = (2.0 + g * g) * (1.0 + g * g - 2.0 * g * c) ** 1.5
    return np.asarray(3.0 / (8.0 * math.pi) * (1.0 - g * g) * (1.0 + c * c) / away)


def slab_reflectance(albedo: float, g: float = 0.0) -> float:
    """Return the share of diffuse light that an endlessly thick medium sends back.

    R = (1 - s) (1 - 0.139 s) / (1 + 1.17 s), s = sqrt((1 - omega) / (1 - g omega)).
    Source: [M] van de Hulst 1980.
    """
    s = math.sqrt((1.0 - albedo) / (1.0 - g * albedo))
    return (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)
