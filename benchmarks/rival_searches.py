"""Optimizers of other packages as the races run them: least ``account(rows)`` within ``account.bounds``.

An account ends a run by an exception; none of these comes to an end of its own. The packages are in the
dependency group "rivals".
"""

import numpy as np


def scipy_de(account, seed):
    """scipy.optimize.differential_evolution with its defaults, vectorized."""
    from scipy.optimize import differential_evolution

    differential_evolution(
        lambda x: account(x.T),
        account.bounds,
        rng=seed,
        vectorized=True,
        updating="deferred",
        polish=False,
        tol=0.0,
        maxiter=10**6,
    )


def pycma(account, seed):
    """CMA-ES with its defaults, from random points until the limit."""
    import cma

    low, high = account.bounds.T
    rng = np.random.default_rng(seed)
    while True:
        search = cma.CMAEvolutionStrategy(
            rng.uniform(low, high),
            0.25,
            {"bounds": [low.tolist(), high.tolist()], "seed": int(rng.integers(1, 2**31)), "verbose": -9},
        )
        while not search.stop():
            candidates = search.ask()
            search.tell(candidates, account(np.array(candidates)).tolist())


def pymoo_ga(account, seed):
    """pymoo's genetic algorithm with 160 individuals."""
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    class Wrapped(Problem):
        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = account(x)

    low, high = account.bounds.T
    minimize(Wrapped(n_var=len(low), n_obj=1, xl=low, xu=high), GA(pop_size=160), ("n_gen", 10**6), seed=seed)
