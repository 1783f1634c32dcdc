"""The search: an island genetic algorithm over f(x) within bounds, and its checkpoint on disk.

It knows f(x) only, never a structure; the loop runs in the Rust core.

References: V. Meruane, J. Sound Vib. 332 (2013) 807-820, section 4; J. A. Joines and C. R. Houck, Proc. IEEE
ICEC (1994) 579-584.
"""
