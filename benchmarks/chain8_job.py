"""The job that the studies of interrupted and killed runs share: 15 parameters of the eight-mass chain."""

#: The measurement of both: antiresonances that are known already.
MEASURED = """\
[data]
file = "measured.json"
"""
#: Model and parameters; ends within [search].
UPDATING = """\
[model]
kind = "chain"
masses_kg = [0.5593, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194, 0.4194]
springs_n_per_m = [56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3, 56.7e3]
[[parameters]]
kind = "mass_factor"
terms = "all"
bounds = [0.9, 1.1]
[[parameters]]
kind = "stiffness_factor"
elements = "all"
bounds = [0.9, 1.1]
[search]
"""
