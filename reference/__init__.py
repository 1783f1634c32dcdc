"""Structures, records and oracles with known answers, which tests and benchmarks compare with."""
