"""Results as rows: an HTML table for notebooks, a pandas frame, and a plot."""

from __future__ import annotations

from abc import abstractmethod
from html import escape
from typing import Any, ClassVar

from morph.arrays import JSON
from morph.extras import require

MOST_SHOWN = 40
"""Rows of the HTML table; a frame has all."""


class Tabular:
    """A result whose content can be read as rows of named values."""

    axes: ClassVar[tuple[str, ...]] = ()
    """Column along which `plot` draws, and the columns that it draws; empty: all numbers."""

    @abstractmethod
    def rows(self) -> list[JSON]:
        """Return one dictionary a row, all with the same keys."""

    def to_pandas(self) -> Any:
        """Return the rows as a `pandas.DataFrame`.

        Raises:
            MissingPackage: pandas is not installed.
        """
        require("notebook", f"{type(self).__name__}.to_pandas")
        import pandas

        return pandas.DataFrame(self.rows())

    def plotted(self) -> list[JSON]:
        """Return the rows that `plot` draws."""
        return self.rows()

    def plot(self) -> Any:
        """Return a `plotly.graph_objects.Figure`: bars over names, lines over numbers."""
        from plotly import graph_objects

        figure, rows = graph_objects.Figure(), self.plotted()
        if not rows:
            return figure
        along, *drawn = self.axes or (next(iter(rows[0])),)
        numbers = [name for name, value in rows[0].items() if isinstance(value, float)]
        kind = graph_objects.Bar if isinstance(rows[0][along], str) else graph_objects.Scatter
        for name in drawn or numbers:
            x, y = ([row[each] for row in rows] for each in (along, name))
            figure.add_trace(kind(x=x, y=y, name=name))
        figure.update_layout(title=repr(self), xaxis_title=along)
        return figure

    def _repr_html_(self) -> str:
        rows = self.rows()
        shown, more = rows[:MOST_SHOWN], len(rows) - MOST_SHOWN
        head = "".join(f"<th>{escape(name)}</th>" for name in (rows[0] if rows else {}))
        body = "".join(
            f"<tr>{''.join(f'<td>{escape(_text(value))}</td>' for value in row.values())}</tr>"
            for row in shown
        )
        left = f"<p>and {more} more rows</p>" if more > 0 else ""
        return f"<p>{escape(repr(self))}</p><table><tr>{head}</tr>{body}</table>{left}"


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
