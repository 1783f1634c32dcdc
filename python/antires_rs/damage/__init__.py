"""Damage: which elements have lost stiffness, how much, and how sure that is.

Two states of a structure are compared, intact and as it is now. The change that was measured is set against
the changes that damage of each element, pair and triple of elements would make in the model:

    ln f_now - ln f_intact = ln r(beta, theta) - ln r(0, theta) + errors

The intact state tells how wrong the model is (theta); the likelihood says how probable the values of now are
for given severities; the search finds the sets of elements that explain them and weighs these.
"""
