"""What a reader should know before trusting an assessment."""

from __future__ import annotations

from ..updating.reduction import ReductionReport
from .assessment import Assessment
from .percent import figure
from .phrases import Label

__all__ = ["note_of_reduction", "reservations"]

#: With fewer values to spare a fit says little.
_FEW = 4


def reservations(found: Assessment, label: Label) -> list[str]:
    """What a reader should know before trusting it."""
    notes = list(found.notes)
    if not found.baseline:
        notes.append(
            "Without a baseline every error of the model counts as damage. The probabilities assume "
            f"stiffnesses and masses within about {figure(found.factor_std)}; give the values of the "
            "intact structure as baseline= to have the model's errors taken out."
        )
    if not found.n_matched:
        notes.append(
            "No value of now has a partner in the model: there is no chi-square, and nothing tells whether "
            "the answer holds. Compare the bands and dofs of both tests."
        )
    elif not found.best.unknown and not found.explained:
        notes.append(
            f"The most probable hypothesis does not explain the values (reduced chi-square "
            f"{found.chi_square:.1f}): something else may have changed as well."
        )
    lost = found.n_values - found.n_matched
    if lost and found.n_matched:
        notes.append(
            f"{lost} of {found.n_values} values {'has' if lost == 1 else 'have'} no partner in the model: "
            "new or false."
        )
    spare = found.n_matched - len(found.best.severities)
    if found.n_values and spare < _FEW:
        notes.append(
            f"Only {found.n_matched} value{'s are' if found.n_matched != 1 else ' is'} compared, "
            f"{max(spare, 0)} more than there are losses to tell: the answer rests on what the prior says of "
            "how many elements are damaged, and hardly anything is left to check it by. Measure at more "
            "dofs, or in a wider band."
        )
    if found.baseline and found.kappa > 0.0:
        notes.append(
            f"The model predicts changes to about {figure(found.kappa)}: it explained the baseline to "
            f"{figure(found.root_std)}."
        )
    if found.n_baselines == 1:
        notes.append(
            "One test of the intact structure: how far values scatter from test to test is not known, their "
            "own standard deviations count."
        )
    elif found.scatter > 1.0:
        notes.append(
            f"Values scatter between the intact tests {found.scatter:.1f} times as much as their standard "
            "deviations say; all of them were multiplied by that."
        )
    if found.assumed_std:
        notes.append("Values without standard deviation count as known to 0.05 %.")
    return notes


def note_of_reduction(found: ReductionReport) -> str:
    """How a reduced model served."""
    if found.agreed:
        return found.note
    return (
        f"Sought on a reduced model, {found.size} dofs for {found.n_dof}: at the answer its antiresonances "
        f"still differ from the full model's by {found.difference:.0e}, which moves severities and "
        "probabilities by as much. reduction=False assesses on the full model, which takes long."
    )
