"""What rays and flights bring together is all that there is, at every distance, and no ray brings more than its event's weight."""

import math

import numpy as np
import pytest

from transport.physics import connections

DISTANCES = np.geomspace(1e-12, 1e12, 49)
PEAKS = [1 / math.pi, 0.25 / math.pi, 1e4]


@pytest.mark.parametrize("peak", PEAKS)
def test_rays_and_flights_share_a_crossing_of_a_flat_detector(peak):
    area, cosine = 0.3, 0.7
    for r2 in DISTANCES**2:
        whole = connections.flat_connection(r2, area, cosine, 0.0)
        ray, flight = (
            connections.flat_connection(r2, area, cosine, peak),
            connections.flights_share(r2, area, peak),
        )
        assert whole == pytest.approx(
            area * cosine / r2, rel=1e-14, abs=0
        )  # one over the density of the direction
        assert ray + flight * whole == pytest.approx(whole, rel=1e-12, abs=0)
        assert peak * ray <= cosine * (1 + 1e-14)


@pytest.mark.parametrize("peak", PEAKS)
def test_they_share_a_crossing_of_a_ball(peak):
    radius = 0.3
    area = math.pi * radius**2
    for d2 in DISTANCES**2:
        whole = connections.ball_connection(d2, radius, area, 0.0)
        ray, flight = (
            connections.ball_connection(d2, radius, area, peak),
            connections.flights_share(d2, area, peak),
        )
        assert ray + flight * whole == pytest.approx(whole, rel=1e-12, abs=0)
        assert peak * ray <= 4 * (1 + 1e-14)
    far, near = (
        connections.ball_connection(1e8, radius, area, 0.0),
        connections.ball_connection(0.04, radius, area, 0.0),
    )
    assert far == pytest.approx(area / 1e8, rel=1e-8, abs=0)  # the solid angle of the ball ...
    assert near == pytest.approx(4 * math.pi, rel=1e-14, abs=0)  # ... which is all about what is within it


def test_an_event_on_the_detector_is_left_to_its_flight():
    assert connections.flat_connection(0.0, 1.0, 0.0, 0.3) == 0.0
    assert connections.flights_share(0.0, 1.0, 0.3) == 1.0
    assert connections.ball_connection(0.0, 1.0, math.pi, 0.3) == 0.0
    assert connections.ball_connection(0.0, 1.0, math.pi, 0.0) == pytest.approx(4 * math.pi)
