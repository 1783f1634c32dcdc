"""The search: an island genetic algorithm over f(x) within bounds, and its checkpoint on disk.

Knows f(x) only, never a structure. Uses ``support`` and the Rust core, which runs the loop.

- ``island_ga``: four islands of 40, one crossover each, exchange of the best when an island stagnates
- ``checkpoint``: a search written to disk and resumed, bit-identical

References: V. Meruane, J. Sound Vib. 332 (2013) 807-820, section 4; J. A. Joines and C. R. Houck, Proc. IEEE
ICEC (1994) 579-584.
"""
