"""The exhaust system of Meruane's second case, as a documented surrogate."""

from .case import Exhaust, exhaust

__all__ = ["Exhaust", "exhaust"]
