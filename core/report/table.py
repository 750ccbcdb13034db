"""Tables of results: rows of numbers and texts with named columns, as CSV, JSON and HTML."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

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

    def csv(self) -> str:
        """Comma-separated values, the names of the columns first."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([["" if cell is None else plain(cell) for cell in row] for row in self.rows])
        return text.getvalue()

    def records(self) -> list[dict[str, Cell]]:
        """One mapping of column to value for each row, for JSON."""
        return [dict(zip(self.columns, (plain(cell) for cell in row), strict=True)) for row in self.rows]

    def html(self) -> str:
        """A table element; numbers are aligned to the right."""
        head = "".join(f"<th>{escape(column)}</th>" for column in self.columns)
        body = "".join(f"<tr>{''.join(_html_cell(cell) for cell in row)}</tr>" for row in self.rows)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def plain(value):
    """A value as JSON knows it: NumPy's numbers become Python's, and numbers that are not finite become None."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _html_cell(cell: Cell) -> str:
    cell = plain(cell)
    if cell is None:
        return "<td>-</td>"
    if isinstance(cell, bool):
        return f"<td>{'yes' if cell else 'no'}</td>"
    if isinstance(cell, int):
        return f'<td class="number">{cell:,}</td>'
    if isinstance(cell, float):
        return f'<td class="number">{cell:,.4g}</td>' if abs(cell) < 1e4 else f'<td class="number">{cell:,.0f}</td>'
    return f"<td>{escape(cell)}</td>"


def table(columns: Sequence[str], rows: Sequence[Sequence[Cell]]) -> Table:
    """A :class:`Table` of any sequences."""
    return Table(tuple(columns), tuple(tuple(row) for row in rows))
