"""Every tolerance of these tests, with its reason."""

AGAINST_SCIPY = 1e-7  # bar of the comparison with scipy.linalg.eig over random models, relative, in Hz
CLOSED_FORM = 1e-9  # both routes and a closed form of a small, well-conditioned chain: 1e-12 in practice
ZERO_ROOT = 1e-9  # roots below this part of the highest eigenvalue are the rigid-body ones at zero
EIGH = 1e-11  # eigenvalues and orthonormality against LAPACK, relative to the largest: n ulp times 1000
FRF = 1e-9  # against a direct inverse: near a resonance the condition of K - w^2 M reaches 1e5
ROUNDING = 1e-14  # a few floating-point operations
RECORD_STATISTICS = 0.035  # of noise over 32768 samples: 1/sqrt(n) is 0.0055, six of them
H1_SIGMAS = 5.0  # mean of an H1 estimate: standard errors allowed beside its bias
SPHERE = 2e-3  # what agreement in cost to 1e-4 of improvement, the search's own stop, leaves in x
GENE_AGREEMENT = 1e-6  # spread of the islands' bests (the option's default, bounds of width 1)
COST = 1e-9  # against the same formulas in numpy: both carry the rounding of an 8 x 8 eigenproblem
EXACT_SEVERITY = 1e-4  # on exact data (the optimizer's gene tolerance, over a bound range of 0.99)
DETECTABLE_PERCENT = 1.5  # smallest visible severity of springs 0 and 1, "about" 10 and 5 %
UPDATED_PERCENT = 0.58  # after updating on exact data with a budget of 30,000: the paper's own
LAW = 1e-10  # laws of small, well-conditioned chains: a hundred thousand ulp, for sums and roots on the way
DIP = 1e-6  # receptance at a zero over that one per cent aside, where the slope alone would give 0
INTERRUPT_S = 2.0  # from Ctrl-C to the end of the process: the bar is 1, doubled for slow machines
FRAME_PACKAGE_HZ = 1e-6  # first ten frequencies against an independent finite-element package: the bar
FRAME_PACKAGE_ENTRIES = 1e-13  # of its matrices, relative to the largest: rounding of rotations and sums
RIGID_FORCE = 1e-13  # of a rigid motion, relative to the largest stiffness: sums of a few rounded entries
SOFT_ZERO = 1e-9  # of a softly hung frame assembled in two ways, in omega squared: one ulp of K
FOUND_AGAIN = 1e-3  # a tube from exact zeros, relative to its bounds' width: the search's own stop
PROMISE, PROMISE_ULPS = 1e-9, 20.0  # each root within the larger of both, ulps as one of K and M shifts it
