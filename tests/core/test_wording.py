"""Numbers in words."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.wording import amount, area, counted, place, share, share_of, short, time


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
        (share(1.25), "125.0%"),
        (share_of(3, 0), "-"),
        (share_of(3, 4), "75.0%"),
        (time(0.266), "0.27 s"),
        (time(3.44), "3.4 s"),
        (time(1200.4), "1,200 s"),
        (time(0), "0 s"),
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
