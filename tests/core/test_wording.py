"""Numbers in words."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core import wording
from core.wording import (
    amount,
    angle,
    area,
    balance,
    coordinates,
    counted,
    exact,
    exact_share,
    length,
    memory,
    number,
    of,
    place,
    rough,
    share,
    share_of,
    short,
    slide,
    small,
    speed,
    time,
    turn,
)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (counted(1, "clip"), "1 clip"),
        (counted(0, "clip"), "0 clips"),
        (counted(1200, "clip"), "1,200 clips"),
        (counted(2, "way out", "ways out"), "2 ways out"),
        (counted(1, "way out", "ways out"), "1 way out"),
        (amount(0), "0"),
        (amount(0.617), "0.62"),
        (amount(-0.001), "0.00"),
        (amount(-0.0), "0"),
        (amount(9.996), "10.0"),
        (amount(99.96), "100"),
        (amount(2153.4), "2,153"),
        (area(12.34), "12.3 m²"),
        (share(0.6127), "61.3%"),
        (share(0), "0%"),
        (share(1), "100%"),
        (share(0.0001), "< 0.1%"),
        (share(0.9999), "> 99.9%"),
        (share(-0.02), "-2.0%"),
        (share(-0.0001), "0.0%"),
        (share(0.9996), "> 99.9%"),
        (share(1.25), "125.0%"),
        (share_of(3, 0), "-"),
        (share_of(3, 4), "75.0%"),
        (time(0.266), "0.27 s"),
        (time(3.44), "3.4 s"),
        (time(1200.4), "1,200 s"),
        (time(0), "0 s"),
        (time(0.999), "1.0 s"),
        (time(59.96), "60.0 s"),
        (time(-0.001), "0.00 s"),
        (time(math.inf), "never"),
        (place(1.23, -0.04), "(1.2, 0.0) m"),
        (short(math.inf), "endless"),
        (short(math.nan), "-"),
        (share(math.nan), "-"),
        (short(0), "0"),
        (short(0.25), "0.25"),
        (short(847), "847"),
        (short(999.6), "1 k"),
        (short(1500), "1.5 k"),
        (short(999_900), "1 M"),
        (short(44e6), "44 M"),
        (short(-2.5e9), "-2.5 G"),
        (short(0.30000000000000004), "0.3"),
        (amount(math.inf), "endless"),
        (exact(1234.5678, 4), "1,235"),
        (exact_share(0.98), "98%"),
        (exact_share(0.995), "99.5%"),
        (exact_share(150 / 198, 2), "76%"),
        (balance(0.251), "+0.25"),
        (balance(-0.001), "+0.00"),
        (coordinates(1.23, -0.04), "1.2, 0.0"),
        (number(1200), "1,200"),
        (of(3, 1200), "3 of 1,200"),
        (exact(0.125), "0.125"),
        (exact(0.10000000149011612), "0.1"),
        (exact(2.0), "2"),
        (exact(1_500_000), "1,500,000"),
        (exact(0), "0"),
        (exact(math.inf), "endless"),
        (rough(1.2345), "1.2"),
        (rough(123.4), "123"),
        (length(0.617), "0.62 m"),
        (length(1640.2), "1,640 m"),
        (small(0.0213), "2.13 cm"),
        (speed(1.234), "1.23 m/s"),
        (slide(0.0213), "2.13 cm/s"),
        (angle(0), "0°"),
        (angle(math.radians(0.04)), "0.0°"),
        (angle(math.radians(-0.04)), "0.0°"),
        (angle(0.08), "4.6°"),
        (angle(-math.pi / 2), "-90°"),
        (angle(math.radians(9.96)), "10°"),
        (turn(math.pi / 2), "+90°"),
        (turn(-math.pi), "-180°"),
        (turn(-0.001), "0°"),
        (turn(7 * math.pi), "+1,260°"),
        (memory(847), "847 B"),
        (memory(1500), "1.5 kB"),
        (memory(44e6), "44 MB"),
        (memory(4e9), "4 GB"),
        (memory(math.inf), "endless"),
        (place(-1234.5, 0), "(-1,234.5, 0.0) m"),
    ],
)
def test_words(said, words):
    assert said == words


@given(st.floats(1e-6, 1e11))
def test_a_short_number_is_near_and_never_has_an_exponent(value):
    text = short(value)
    number, _, letter = text.partition(" ")
    assert float(number) * {"": 1, "k": 1e3, "M": 1e6, "G": 1e9}[letter] == pytest.approx(value, rel=0.006)
    assert "e" not in text and len(number) <= 10


@given(st.floats(0, 1))
def test_nothing_and_everything_are_said_only_of_themselves(part):
    assert (share(part) == "0%") == (part == 0) and (share(part) == "100%") == (part == 1)
    assert "100.0" not in share(part) and share(part) != "0.0%"


def test_what_is_out_of_all_bounds_is_said_shortly():
    w = wording
    for say in (w.short, w.exact, w.amount, w.area, w.length, w.time, w.small, w.speed, w.memory):
        for value in (1e15, -1e20, 1e300, 1.7e308):
            assert len(say(value)) <= 24, (say, value)
    assert len(w.number(10**300)) <= 24 and w.number(10**400) == "more than 1e308"
    assert len(w.quoted("x" * 10**6)) <= 60 and len(w.quoted(10**5000)) <= 60
