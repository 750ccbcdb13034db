"""Tables of results: rows of numbers and texts with named columns, as CSV, JSON and HTML."""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from .. import wording

Cell = str | int | float | bool | None


@dataclass(frozen=True)
class Table:
    """Named columns, units in the name ("area (m2)"), and rows of as many cells; None where there is no value."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def __post_init__(self):
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"a row of {len(row)} cells in a table of {len(self.columns)} columns")

    def first(self, n: int) -> "Table":
        """Return a table of the first ``n`` rows."""
        return Table(self.columns, self.rows[:n])

    def texts(self, column: int) -> list[str]:
        """Return the cells of a column as texts."""
        return [str(row[column]) for row in self.rows]

    def values(self, column: int) -> list[float]:
        """Return the cells of a column of numbers; not a number where there is no value.

        >>> table(("clip", "wait (s)"), [("walk", 2), ("turn", None)]).values(1)
        [2.0, nan]
        """
        return np.array([row[column] for row in self.rows], dtype=float).tolist()

    def csv(self) -> str:
        """Write comma-separated values, the names of the columns first."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([_inert(column) for column in self.columns])
        writer.writerows([["" if cell is None else _inert(plain(cell)) for cell in row] for row in self.rows])
        return text.getvalue()

    def records(self) -> list[dict[str, Cell]]:
        """Return a mapping of column to value for each row, for JSON."""
        return [dict(zip(self.columns, (plain(cell) for cell in row), strict=True)) for row in self.rows]

    def html(self) -> str:
        """Write a table element for people; numbers are aligned to the right.

        A last column "unit" says how the numbers of each row are meant; elsewhere the name of the column does:
        its unit in brackets, or "share" for shares from 0 to 1.
        """
        by_row = self.columns[-1:] == ("unit",)
        columns = self.columns[:-1] if by_row else self.columns
        head = "".join(f"<th>{escape(_UNITS.sub(_raised, column))}</th>" for column in columns)
        body = ""
        for row in self.rows:
            cells = row[:-1] if by_row else row
            units = [f" {row[-1]}"] * len(cells) if by_row else [_unit_of(column) for column in columns]
            shown = zip(cells, units, strict=True)
            body += f"<tr>{''.join(_html_cell(cell, unit) for cell, unit in shown)}</tr>"
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


#: The characters that a formula can begin with, in full width, too.
_FORMULA = frozenset("=+-@\t\uff1d\uff0b\uff0d\uff20")

_UNITS = re.compile(r"\b(m|rad)2\b")


def _raised(unit: re.Match[str]) -> str:
    return f"{unit[1]}²"


def _unit_of(column: str) -> str:
    """Return "share", or the unit in the name of a column."""
    unit = re.search(r"\(([^()]*)\)$", column)
    return unit[1] if unit else "share" if re.search(r"\bshare\b", column) else ""


def plain(value):
    """Convert a value for JSON: NumPy's numbers become Python's, and numbers that are not finite become None."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _inert(cell: Cell) -> Cell:
    """Return a cell that no spreadsheet takes for a formula; numbers stay what they are.

    >>> _inert("=1+1"), _inert("walk"), _inert(-1)
    ("'=1+1", 'walk', -1)
    """
    if not isinstance(cell, str):
        return cell
    # Readers take a carriage return for the end of the row.
    text = cell.replace("\r", " ")
    return f"'{text}" if text.lstrip(" \n")[:1] in _FORMULA else text


def _html_cell(cell: Cell, unit: str) -> str:
    cell = plain(cell)
    if cell is None:
        return "<td>-</td>"
    if isinstance(cell, bool):
        return f"<td>{'yes' if cell else 'no'}</td>"
    if isinstance(cell, int | float):
        return f'<td class="number">{escape(_words(cell, unit))}</td>'
    return f"<td>{escape(cell)}</td>"


def _words(number: int | float, unit: str) -> str:
    """Write a number for people, with its unit if that begins with a space; others stand in the head of the column."""
    said, unit = unit.startswith(" "), unit.strip()
    if unit == "share" and 0 <= number <= 1:
        return wording.share(number)
    if isinstance(number, int):
        text = wording.number(number)
    elif unit in ("m2", "m", "s"):
        text = wording.amount(number)
    else:
        # Costs, variabilities, coordinates of whatever size: four digits, and never an exponent.
        text = "0" if abs(number) < 1e-4 else wording.exact(number, 4)
    return f"{text} {_UNITS.sub(_raised, unit)}".rstrip() if said else text


#: Nothing in rows.
EMPTY = Table((), ())


def table(columns: Sequence[str], rows: Sequence[Sequence[Cell]]) -> Table:
    """Build a :class:`Table` of any sequences.

    >>> print(table(("clip", "area (m2)"), [("walk", 2.5), ("jump", None)]).csv())
    clip,area (m2)
    walk,2.5
    jump,
    <BLANKLINE>
    """
    return Table(tuple(columns), tuple(tuple(row) for row in rows))
