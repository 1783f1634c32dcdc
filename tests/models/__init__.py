"""Chains, frames and matrices: modes, responses, antiresonances."""
