"""Units: one spelling, products, and what is refused."""

import math

import pytest

from transport.units import Unit, UnitError, deg, nm, speed_of_light


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("W m^-2 sr^-1", "W m^-2 sr^-1"),
        ("sr^-1 W/m^2", "W m^-2 sr^-1"),
        ("J/s", "W"),
        ("W s m^-2", "J m^-2"),
        ("m^-1 m", "1"),
        ("1", "1"),
        ("s^-1 m^-2 sr^-1", "s^-1 m^-2 sr^-1"),
        ("m^(1/2)", "m^(1/2)"),
    ],
)
def test_units_print_in_one_order_whatever_was_written(text, printed):
    assert str(Unit.parse(text)) == printed
    assert Unit.parse(printed) == Unit.parse(text)
    assert hash(Unit.parse(printed)) == hash(Unit.parse(text))


def test_units_multiply_and_a_joule_is_a_watt_second():
    W, J, s, m = map(Unit.parse, ("W", "J", "s", "m"))
    assert W * s == J
    assert J / s == W
    assert J / W == s
    assert W / m**2 * s == Unit.parse("J m^-2")
    assert (W**2) ** 0.5 == W
    assert W / W == Unit()
    assert W != J
    assert 1 / 550 * nm * speed_of_light > 0
    assert 180 * deg == pytest.approx(math.pi, rel=1e-15)


@pytest.mark.parametrize("text", ["", "W m-2", "W^", "W ** 2"])
def test_an_unreadable_unit_is_refused(text):
    with pytest.raises(UnitError, match="Cannot parse"):
        Unit.parse(text)
