"""Complete studies: a model, its virtual experiment, and the truth to compare with."""

from .chain8 import Chain8, chain8
from .exhaust import Exhaust, exhaust

__all__ = ["Chain8", "Exhaust", "chain8", "exhaust"]
