"""The limits of the selection, all in one place, each with its reason.

Those of averaged records were set on simulated structures (chains, random stiffness, a plane frame; seeds
100-119), never on the records that the published tables are made from; those of dips and of fits over
windows on six states of a measured plate, and judged on measured frames and a beam. What a caller may
change is in :class:`~antires_rs.FitOptions`.
"""

from __future__ import annotations

# --- the diagram
#: Damping ratio up to which changes of damping are taken relative to this where both signs are allowed.
SMALL_DAMPING = 0.01

# --- what all channels share
#: Roots of all responses this close, relative to abs(s), are one common factor of the numerators.
SHARED = 0.003
#: Largest spread over the channels of a value that they share: a mode that the force hardly excites. On
#: measured frames and beams at most 0.41 %; antiresonances of neighbouring parts of a chain came within
#: 0.6 %.
COMMON = 0.005
#: Depth of a dip from which it is the response's own, though all others have one beside it.
COMMON_DEPTH_DB = 10.0
#: A zero this near to a root that all responses share is doubtful.
NEARLY_SHARED = 0.05

# --- the flanks of a value
#: They lie this far on either side of it, as shares of its frequency.
FLANK = (0.02, 0.20)
#: Signal-to-noise power there that a persistent value needs (6 dB), and a candidate of the cross-check
#: (3 dB).
PERSISTENT_SNR, CANDIDATE_SNR = 4.0, 2.0

# --- values that are in most orders without standing still
#: Poles within this share of a frequency are taken for the same value.
WIDTH = 0.02
#: In this share of the orders from the first appearance on there must be one.
PRESENCE = 0.75
#: Spurious poles of a noisy fit are not all weak: here a pole must own the curve at its frequency.
PERSISTENT_DOMINANCE = 0.7
PERSISTENT_DAMPING = 0.05

# --- zeros of the likeliest numerators
#: A chain and a zero of the likeliest fit this close belong together: the chain may be biased by so much.
SAME = 0.05
#: Largest standard deviation in frequency tolerances.
KNOWN = 0.5
#: Damped less than this, or right of the axis, are few physical zeros (two that nearly coincide part so), and
#: many roots glued to the noise of single lines: such a zero must own this much of its curve.
LEAST_DAMPING, MOST_NEGATIVE = 5e-4, 0.01
RIGHT_DOMINANCE = 0.9
#: Two zeros of one modulus, whose frequencies differ by less than this share of the difference of their
#: damping ratios, are the halves of one that is complex without damping; at least so far apart in damping.
PAIR, PAIR_DAMPING = 0.5, 0.004
#: Roots up to this damping, and with this share of the curve, may be the other half of such a pair.
WIDEST, OTHER_HALF = 0.15, 0.02
#: A zero that owns less than this share of its curve is doubtful. What is doubtful needs a root of the same
#: frequency and damping in PRESENCE of the higher orders.
WEAK = 0.5
SAME_DAMPING = 0.002

# --- the cross-check
#: Poles: this many more than the dof with most values has, and never fewer than the second number.
MORE_POLES, LEAST_POLES = 8, 12
#: A pole that owns less of the curve confirms nothing, one that owns less than the second is no candidate.
CONFIRMING_DOMINANCE, CANDIDATE_DOMINANCE = 0.3, 0.7
CROSS_CHECK_DAMPING = 0.10

# --- dips and peaks of a curve
#: On either side a dip is followed this far, as a share of its frequency; never less than the second number
#: of lines. A zero of 4 % damping makes a dip of 3 dB.
DIP_REACH, DIP_LINES = 0.04, 4
#: How far the root that a dip belongs to may lie from it, as a share of its frequency.
OWNER_WITHIN = 0.01
#: A dip of the response's own curve that belongs to one of its direction lies this near.
OWN_DIP_WITHIN = 0.02
#: A dip must be so many standard deviations of the noise beside it deep, where that is less than the rule
#: asks for: what is shallow is believed only of curves that are as good as exact. Shallower ones never count.
DIP_OVER_NOISE, LEAST_DIP_DB = 35.0, 0.5

# --- fits over windows
#: Zeros of several fits are one antiresonance within this share of the frequency tolerance; two that are
#: accepted lie at least ONE_DIP apart.
CLUSTER, ONE_DIP = 0.7, 0.01

# --- peaks that nothing explains
#: A peak of the curve behind a diagram this high, after averaging the power over so many lines, is named
#: where no accepted antiresonance lies within this share of its frequency.
PEAK_DB, PEAK_LINES, EXPLAINED_WITHIN = 10.0, 5, 0.02
