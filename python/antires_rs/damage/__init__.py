"""Damage: which elements have lost stiffness, how much, and how sure that is.

The intact state tells how wrong the model is; the likelihood says how probable the values of now are for
given severities; the search finds the sets of elements that explain them and weighs these.
"""
