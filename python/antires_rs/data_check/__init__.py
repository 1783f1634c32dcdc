"""Data check: what measured data can bear, and what is wrong with them, before anything is fitted."""

from .check import check_data
from .findings import DataCheck, Finding

__all__ = ["DataCheck", "Finding", "check_data"]
