"""Fits of rising order: which poles are stable, which are accepted, and what speaks for each.

Knows the stabilization diagram and its rule. Uses ``rational``, ``signals``, ``support``; neither where the
curves come from nor what the poles mean.

A pole is stable if the next lower order has one within 1 % in frequency and a given share in damping; it is
accepted after more than ten consecutive stable orders, if it owns a visible part of the curve.

Reference: V. Meruane, J. Sound Vib. 332 (2013) 807-820, section 3.
"""
