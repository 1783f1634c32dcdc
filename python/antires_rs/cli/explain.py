"""``antires explain``: what a warning means."""

from __future__ import annotations

import argparse

from ..support.explained import explain as told

__all__ = ["explain"]


def explain(args: argparse.Namespace) -> int:
    """Print what is known of the names."""
    print(told(*args.names))
    return 0
