"""Every tolerance of these tests, with its reason."""

#: Bar of the comparison with scipy.linalg.eig over random models, relative, in Hz.
AGAINST_SCIPY = 1e-7
#: Both routes and a closed form of a small chain: a well-conditioned problem, 1e-12 in practice.
CLOSED_FORM = 1e-9
#: Roots below this part of the highest eigenvalue are the rigid-body ones at zero.
ZERO_ROOT = 1e-9
#: Eigenvalues and orthonormality against LAPACK, relative to the largest: n ulp with a margin of 1000.
EIGH = 1e-11
#: Frequency response against a direct inverse: near a resonance the condition of K - w^2 M reaches 1e5.
FRF = 1e-9
#: A few floating-point operations.
ROUNDING = 1e-14
#: Level, whiteness and independence of noise over 32768 samples: 1/sqrt(n) is 0.0055, six of them.
RECORD_STATISTICS = 0.035
#: Mean of an H1 estimate: standard errors allowed beside its bias.
H1_SIGMAS = 5.0
#: The sphere at the search's own stop: agreement in cost to 1e-4 of improvement leaves this in x.
SPHERE = 2e-3
#: Spread of the islands' bests that counts as agreement (the option's default, bounds of width 1).
GENE_AGREEMENT = 1e-6
#: Cost against the same formulas in numpy: both carry the rounding of an 8 x 8 eigenproblem.
COST = 1e-9
#: Severity found on exact data (the optimizer's gene tolerance, over a bound range of 0.99).
EXACT_SEVERITY = 1e-4
#: Smallest visible severity of springs 0 and 1, "about" 10 and 5 %.
DETECTABLE_PERCENT = 1.5
#: Largest difference after updating on exact data with a budget of 30,000: 0.58 % is the paper's own.
UPDATED_PERCENT = 0.58
#: Laws of small, well-conditioned chains: a hundred thousand ulp, for the sums and roots on the way.
LAW = 1e-10
#: Components of the rigid-body shape: its eigenvalue is separated by at least the softest mode.
RIGID = 1e-9
#: Receptance at a zero over that one per cent aside, where the slope alone would give 0.
DIP = 1e-6
#: Error of the severity at 1 % sensor noise: the bar.
NOISY_SEVERITY = 0.02
#: Seconds from Ctrl-C to the end of the process: the bar is 1, doubled for slow machines.
INTERRUPT_S = 2.0
#: First ten frequencies against an independent finite-element package (the bar of row 2).
FRAME_PACKAGE_HZ = 1e-6
#: Entries of its matrices, relative to the largest: rounding of rotations and sums.
FRAME_PACKAGE_ENTRIES = 1e-13
#: Forces of a rigid motion, relative to the largest stiffness: sums of a few rounded entries.
RIGID_FORCE = 1e-13
#: Zeros of a softly hung frame assembled in two ways, in omega squared: one ulp of K is 1e-9 of them.
SOFT_ZERO = 1e-9
#: A tube found again from exact zeros, relative to its bounds' width: the search's own stop.
FOUND_AGAIN = 1e-3
#: The promise: each root within max(PROMISE, PROMISE_ULPS times the shift of one ulp in K and M).
PROMISE = 1e-9
PROMISE_ULPS = 20.0
