"""When a pole counts: the limits of the stabilization, and the orders it needs to be applied at all."""

from __future__ import annotations

from dataclasses import dataclass

from ..support.validation import finite_scalar, integer, reject

# Real numbers of data that an order needs: with fewer, poles follow the noise of single lines.
DATA_PER_ORDER = 3


@dataclass(frozen=True)
class Rule:
    """When a pole is stable, and when a chain of them is accepted."""

    freq_tol: float = 0.01
    damping_tol: float = 0.10
    min_rows: int = 10
    max_damping: float = 0.10
    min_dominance: float = 0.05
    # Zeros, unlike poles, may lie right of the axis: measured ones of light damping often do, a little.
    both_sides: bool = False
    # Accept what is there in most orders without standing still.
    persistent: bool = True
    # Of the fits over windows: this share of them must have it, as a dip of so many dB.
    min_share: float = 0.5
    min_depth_db: float = 3.0

    def checked(self) -> Rule:
        """Same rule, or an error that names the bad option."""
        finite_scalar("freq_tol", self.freq_tol, low=0.0, high=0.5, low_open=True)
        finite_scalar("damping_tol", self.damping_tol, low=0.0, high=1.0, low_open=True)
        integer("min_rows", self.min_rows, low=1)
        finite_scalar("max_damping", self.max_damping, low=0.0, high=1.0, low_open=True)
        finite_scalar("min_dominance", self.min_dominance, low=0.0)
        finite_scalar("min_share", self.min_share, low=0.0, high=1.0, low_open=True)
        finite_scalar("min_depth_db", self.min_depth_db, low=0.0, low_open=True)
        return self

    def check_span(self, min_order: int, max_order: int) -> None:
        """Refuse orders among which no chain could be long enough."""
        if max_order - min_order < self.min_rows:
            reject(
                "max_order",
                max_order,
                f"at least min_order + min_rows = {min_order + self.min_rows}",
                "A value is accepted only when more than min_rows consecutive orders agree.",
            )

    def orders(self, wanted: tuple[int, int], n_lines: int, *, per_line: int = 2) -> range:
        """Of the orders wanted, (lowest, highest), those that lines of ``per_line`` real numbers can bear."""
        low, high = wanted[0], min(wanted[1], per_line * n_lines // DATA_PER_ORDER)
        if high - low < self.min_rows:
            reject(
                "band_hz",
                f"a band with {n_lines} lines for orders {low} to {high}",
                f"orders that span more than min_rows = {self.min_rows}",
                "Widen the band, or use longer segments.",
            )
        return range(low, high + 1)
