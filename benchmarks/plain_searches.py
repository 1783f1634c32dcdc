"""Plain searches for damage, as anyone would write them on our objective and its sensitivities.

Each takes an account (``account(rows)`` for costs, ``account.linearized(x)`` for J, residuals and their
slopes) and a seed, and returns when it knows no further step; the account keeps the best point. All of them
end in ``refit`` and ``prune``, so that what differs is where they look.
"""

import numpy as np
from scipy.optimize import least_squares, linprog

#: Sizes of a damage that a scan begins with.
SIZES = np.array([0.12, 0.32, 0.52, 0.7, 0.82, 0.92])
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
SHRINKS = 10


def raised(x):
    """Elements with damage."""
    return np.flatnonzero(x > 0.0)


def step(residuals, slopes, price, low, high):
    """Least ``sum(abs(e + A d)) + price * sum(d)`` within the bounds, a linear program."""
    m, n = slopes.shape
    cost = np.r_[np.full(n, price), np.ones(m)]
    rows = np.block([[slopes, -np.eye(m)], [-slopes, -np.eye(m)]])
    ends = [*zip(low, high, strict=True), *[(0.0, None)] * m]
    return linprog(cost, A_ub=rows, b_ub=np.r_[-residuals, residuals], bounds=ends).x[:n]


def refit(account, x, free=None, price=None, steps=20):
    """Sequential linear programming on some elements; default: those raised, at their price in J."""
    free = raised(x) if free is None else free
    penalty, high = account.problem.penalty, account.bounds[:, 1]
    price = penalty.gamma1 if price is None else price
    radius = 0.25
    x = x.copy()
    if free.size == 0:
        return x, account(x[None])[0]

    def worth(cost, x):
        return cost + (price - penalty.gamma1) * x.sum() - penalty.gamma2 * raised(x).size

    cost, e, slopes = account.linearized(x)
    for _ in range(steps):
        low, up = np.maximum(-x[free], -radius), np.minimum(high[free] - x[free], radius)
        d = step(e, slopes[:, free], price, low, up)
        foretold = np.abs(e).sum() - np.abs(e + slopes[:, free] @ d).sum() - price * d.sum()
        if foretold <= 1e-9 * (1.0 + abs(cost)) or radius < 1e-7:
            break
        trial = x.copy()
        trial[free] = np.clip(x[free] + d, 0.0, high[free])
        new, new_e, new_slopes = account.linearized(trial)
        gain = worth(cost, x) - worth(new, trial)
        radius = min(2.0 * radius, 1.0) if gain > 0.75 * foretold else radius
        radius = 0.25 * radius if gain < 0.25 * foretold else radius
        if gain > 0.0:
            x, cost, e, slopes = trial, new, new_e, new_slopes
    return x, cost


def prune(account, x, cost):
    """Drops one element after another as long as J falls, each time with a refit of the others."""
    while raised(x).size:
        trials = np.repeat(x[None], raised(x).size, axis=0)
        trials[np.arange(len(trials)), raised(x)] = 0.0
        costs = account(trials)
        least = int(np.argmin(costs))
        smaller, its_cost = refit(account, trials[least])
        if its_cost >= cost:
            break
        x, cost = smaller, its_cost
    return x, cost


def line_searches(account, base):
    """The best size of every element at rest, added to ``base``: [(cost, x)], by golden sections."""
    genes = np.flatnonzero(base == 0.0)
    high = account.bounds[genes, 1]

    def costs(sizes):
        trials = np.repeat(base[None], genes.size, axis=0)
        trials[np.arange(genes.size), genes] = sizes
        return account(trials), trials

    grid = [costs(size * high)[0] for size in SIZES]
    at = np.argmin(grid, axis=0)
    ends = np.r_[0.0, SIZES, 1.0]
    low, top = ends[at] * high, ends[at + 2] * high
    left, right = top - GOLDEN * (top - low), low + GOLDEN * (top - low)
    (of_left, _), (of_right, _) = costs(left), costs(right)
    for _ in range(SHRINKS):
        inner = of_left < of_right
        low, top = np.where(inner, low, left), np.where(inner, right, top)
        new = np.where(inner, top - GOLDEN * (top - low), low + GOLDEN * (top - low))
        of_new, _ = costs(new)
        left, right = np.where(inner, new, right), np.where(inner, left, new)
        of_left, of_right = np.where(inner, of_new, of_right), np.where(inner, of_left, of_new)
    found, trials = costs(0.5 * (low + top))
    return sorted(zip(found, trials, strict=True), key=lambda pair: pair[0])


def scan(account, seed):
    """Each element alone with a line search, the best refined; knows one damage at most."""
    nothing = np.zeros(len(account.bounds))
    account(nothing[None])
    refit(account, line_searches(account, nothing)[0][1])


def pursuit(account, seed):
    """Matching pursuit: the element that explains most is added and all are refitted, as long as J falls."""
    x = np.zeros(len(account.bounds))
    cost = account(x[None])[0]
    while (x == 0.0).any():
        longer, its_cost = refit(account, line_searches(account, x)[0][1])
        longer, its_cost = prune(account, longer, its_cost)
        if its_cost >= cost:
            break
        x, cost = longer, its_cost


def lasso(account, seed):
    """Sequential linear programs over all elements, from a high price of damage to its own; then refits."""
    x, everything = np.zeros(len(account.bounds)), np.arange(len(account.bounds))
    account(x[None])
    for factor in (30.0, 10.0, 3.0, 1.0, 0.3):
        x, _ = refit(account, x, everything, factor * account.problem.penalty.gamma1, steps=8)
        kept = np.where(x > 1e-3, x, 0.0)
        prune(account, *refit(account, kept))


def many_starts(account, seed):
    """Least squares from random points, then drops and refits, until the limit."""
    rng = np.random.default_rng(seed)
    low, high = account.bounds.T
    known = {}

    def at(x):
        if x.tobytes() not in known:
            known.clear()
            known[x.tobytes()] = account.linearized(x)
        return known[x.tobytes()]

    while True:
        fit = least_squares(
            lambda x: at(x)[1],
            rng.uniform(low, 0.5 * high),
            jac=lambda x: at(x)[2],
            bounds=(low, high),
            max_nfev=40,
        )
        prune(account, *refit(account, np.where(fit.x > 0.02, fit.x, 0.0)))
