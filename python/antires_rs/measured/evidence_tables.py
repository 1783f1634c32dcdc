"""A set of antiresonances with what speaks for it and what was seen beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..order_sweep.table import ResponseTable
from ..support.pickling import FrozenDict
from ..support.validation import FloatArray
from .edited_tables import EditedTables
from .evidence import CrossCheck, DataCheck
from .sight import Sees

__all__ = ["EvidenceTables"]


class EvidenceTables(EditedTables):
    """Tables by dof with diagrams, checks, and what was seen and not accepted."""

    _diagrams: FrozenDict[Any, Any]
    _left_out: FrozenDict[Any, ResponseTable]
    _unexplained_hz: FrozenDict[Any, FloatArray]
    _data_check: DataCheck | None
    _cross_check: CrossCheck | None
    _sees: Sees
    _channels: tuple[Any, ...]

    def _fill_diagrams(self, diagrams: Mapping[Any, Any]) -> None:
        """The diagrams, and what they say was not accepted."""
        drawn = {dof: one for dof, one in diagrams.items() if hasattr(one, "unexplained_hz")}
        self._fill(
            _diagrams=FrozenDict(diagrams),
            _left_out=FrozenDict({dof: one.left_out for dof, one in drawn.items()}),
            _unexplained_hz=FrozenDict({dof: one.unexplained_hz for dof, one in drawn.items()}),
        )

    @property
    def sees(self) -> Sees:
        """What it was identified from: "frf", "transmissibility", or None where that is not known."""
        return self._sees

    @property
    def channels(self) -> tuple[Any, ...]:
        """All responses that were measured together; empty where some of them have no name here."""
        return self._channels

    @property
    def diagrams(self) -> Mapping[Any, Any]:
        """Stabilization diagram by dof where the set was identified."""
        return self._diagrams

    @property
    def left_out(self) -> Mapping[Any, ResponseTable]:
        """By dof, where curves were identified: what fits saw and did not accept, with the score "why"."""
        return self._left_out

    @property
    def unexplained_hz(self) -> Mapping[Any, FloatArray]:
        """By dof, where it was identified: peaks of its curve beside which nothing was seen."""
        return self._unexplained_hz

    @property
    def data_check(self) -> Any | None:
        """Whether the data were fit for identification, where they were checked."""
        return self._data_check

    @property
    def cross_check(self) -> Any | None:
        """What another method says of the antiresonances, where it was asked."""
        return self._cross_check

    @property
    def second_opinion(self) -> Any | None:
        """The older name of ``cross_check``."""
        return self._cross_check

    def look(
        self,
        source: Any = None,
        *,
        save_to: Any = None,
        wait: bool | None = None,
        browser: bool = True,
        **options: Any,
    ) -> Any:
        """Open a page of this computer on which the set is looked at and edited.

        Diagram, curve, coherence and singular values of each response, and the table of values with grade,
        error and doubts. A click drops or adds a value, with a reason if one is typed.

        Parameters
        ----------
        source : Recording, FrequencyResponse or a list of either, optional
            What it was identified from. With it curves are shown, and band and orders can be changed.
        save_to : path-like, optional
            Where the page saves the set; without it the page offers a download.
        wait : bool, optional
            Return when the page was closed, or Ctrl-C. By default everywhere but in a notebook, where the
            page stands below the cell and stays open.
        browser : bool
            Open the browser; else the address is printed only.
        **options
            Of :func:`~antires_rs.identify_antiresonances`, for the page to identify again as the set was.

        Returns
        -------
        Page
            ``.zeros`` is the set as it is now, with all edits; ``.url`` the address, ``.stop()`` ends it.

        Raises
        ------
        MissingDependencyError
            bokeh is not installed.
        InvalidInputError
            A source of another kind, or a band outside of it.

        Examples
        --------
        >>> import antires_rs as ar
        >>> page = ar.AntiresonanceSet(0, {0: [8.7, 12.2]}).look(wait=False, browser=False)
        looking at antiresonances, force at 0: http://127.0.0.1:...
        >>> page.zeros[0].tolist(), page.stop()
        ([8.7, 12.2], None)
        """
        from ..explore.page.opened import of_set

        return of_set(self, source, save_to, options, wait=wait, browser=browser)
