//! The antiresonance objective J(x).

use std::sync::Arc;

use crate::antiresonances::{AntiresonanceSolver, Prepared, Query, Route, Transfer};
use crate::error::{Error, Result};
use crate::fem::assembly::Assembly;
use crate::fem::model::{Model, connected};
use crate::fem::parameters::Parameter;
use crate::modal::structure::Structure;

use super::misfit::Misfit;
use super::pairing::{Pairing, UNPAIRED};
use super::penalties::Penalty;
use super::sight::{Sees, shown};
use super::unknowns::{Unknowns, checked_weights};

/// The model's antiresonances are computed to this multiple of the highest measured frequency, so
/// that the edge of the band cuts off no partner.
pub const BAND_MARGIN: f64 = 1.5;

/// Measured antiresonances of one response to one force.
#[derive(Debug, Clone, Default)]
pub struct Target {
    /// Response dof.
    pub dof: usize,
    /// Dof of the force.
    pub excitation: usize,
    /// Antiresonant frequencies (Hz); none where the response only was measured with others.
    pub freq_hz: Vec<f64>,
    /// What they were identified from.
    pub sees: Sees,
    /// Targets of one number were measured together: transmissibilities lose what all of these share.
    pub together: usize,
}

/// J(x) for one model, one parameter set and one measurement.
pub struct AntiresonanceObjective {
    unknowns: Unknowns,
    targets: Vec<Target>,
    misfit: Misfit,
    limit_hz: f64,
    structure: Arc<Structure>,
    connected: Vec<bool>,
    /// For each target those measured with it, where transmissibilities lose what all of them share.
    others: Vec<Vec<usize>>,
    weights: Vec<f64>,
}

/// Working memory of one thread.
pub struct Workspace {
    assembly: Assembly,
    solver: AntiresonanceSolver,
    roots: Vec<Roots>,
}

/// The roots of one response.
#[derive(Debug, Clone, Default)]
pub(super) struct Roots {
    /// Those that may be partners (Hz), ascending.
    pub hz: Vec<f64>,
    /// Those among them that lie on a pole and cancel.
    pub cancelled_hz: Vec<f64>,
    /// Whether the response is there at all.
    present: bool,
}

/// The model at one x, ready to be solved.
pub(super) struct Formed<'a> {
    pub prepared: Prepared<'a>,
    /// Target by target, once [`AntiresonanceObjective::pairs_of`] has found them.
    pub roots: &'a mut Vec<Roots>,
}

impl AntiresonanceObjective {
    /// Joins a model, its parameters and a measurement; `penalty` and `snap` as of [`Unknowns::new`].
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when a dof is outside the model, no antiresonance was measured, or one is
    /// not positive; and those of [`Unknowns::new`].
    pub fn new(
        model: Model,
        parameters: Vec<Parameter>,
        targets: Vec<Target>,
        misfit: Misfit,
        penalty: Option<Penalty>,
        snap: f64,
    ) -> Result<Self> {
        for target in &targets {
            model.check_dof("measured", target.dof)?;
            model.check_dof("excitation", target.excitation)?;
            if let Some(f) = target
                .freq_hz
                .iter()
                .find(|f| !(f.is_finite() && **f > 0.0))
            {
                return Err(Error::input(
                    "measured",
                    format!("{f} Hz at dof {}", target.dof),
                    "positive, finite frequencies",
                )
                .remedy(
                    "Drop it from the measured set: an antiresonance at 0 Hz is a rigid motion.",
                ));
            }
        }
        let highest = targets
            .iter()
            .flat_map(|t| &t.freq_hz)
            .fold(0.0_f64, |m, &f| m.max(f));
        if highest == 0.0 {
            return Err(Error::input("measured", "no antiresonance", "at least one")
                .remedy("Identify in a wider band, or measure at more dofs."));
        }
        let unknowns = Unknowns::new(model, parameters, penalty, snap)?;
        let model = &unknowns.model;
        let connected = targets
            .iter()
            .map(|t| connected(model.stiffness(), model.mass(), t.dof, t.excitation))
            .collect();
        let weights = vec![1.0; targets.iter().map(|t| t.freq_hz.len()).sum()];
        let others = (0..targets.len())
            .map(|nth| measured_with(&targets, nth))
            .collect();
        let structure = Arc::new(Structure::under(model, &unknowns.parameters));
        structure.check_room()?;
        Ok(Self {
            structure,
            unknowns,
            targets,
            misfit,
            limit_hz: BAND_MARGIN * highest,
            connected,
            others,
            weights,
        })
    }

    /// The same objective with residual m multiplied by `weights[m]`, in the order of the targets.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when there is not one finite, not negative weight for each measured value,
    /// or all are zero.
    pub fn with_weights(mut self, weights: Vec<f64>) -> Result<Self> {
        self.weights = checked_weights(weights, self.weights.len())?;
        Ok(self)
    }

    /// The model and what may change in it.
    #[must_use]
    pub fn unknowns(&self) -> &Unknowns {
        &self.unknowns
    }

    /// The analytic partner of each measured antiresonance and its residual, target by target.
    ///
    /// # Errors
    /// Those of the eigenproblem.
    pub fn pairs(&self, x: &[f64], ws: &mut Workspace) -> Result<Vec<Pairing>> {
        self.pairs_of(&mut self.form(x, ws))
    }

    /// J at `x`, of which these are the pairs.
    #[must_use]
    pub fn cost_of(&self, x: &[f64], pairs: &[Pairing]) -> f64 {
        let weighted = pairs.iter().zip(&self.weights);
        let misfit = weighted.fold(0.0, |total, (pairing, weight)| {
            self.misfit.add(total, weight * pairing.residual)
        });
        misfit + self.unknowns.penalty_at(&self.unknowns.snapped(x))
    }

    /// New working memory.
    pub(super) fn memory(&self) -> Workspace {
        Workspace {
            assembly: Assembly::new(&self.unknowns.model),
            solver: AntiresonanceSolver::new(&self.structure),
            roots: vec![Roots::default(); self.targets.len()],
        }
    }

    /// K(x) and M(x).
    pub(super) fn form<'a>(&self, x: &[f64], ws: &'a mut Workspace) -> Formed<'a> {
        let Workspace {
            assembly,
            solver,
            roots,
        } = ws;
        assembly.form(&self.unknowns.model, &self.unknowns.parameters, x);
        Formed {
            prepared: solver.prepare(&assembly.stiffness, &assembly.mass),
            roots,
        }
    }

    /// [`pairs`](Self::pairs) of a model that is formed.
    pub(super) fn pairs_of(&self, formed: &mut Formed<'_>) -> Result<Vec<Pairing>> {
        let mut out = Vec::new();
        self.each_pair(formed, |pairing| out.push(pairing))?;
        Ok(out)
    }

    fn each_pair(&self, formed: &mut Formed<'_>, mut visit: impl FnMut(Pairing)) -> Result<()> {
        self.find_roots(formed)?;
        let roots = &*formed.roots;
        for (nth, target) in self.targets.iter().enumerate() {
            let own = &roots[nth].hz;
            for &measured in &target.freq_hz {
                let shown = |root| shown(own, root, self.others_of(nth, roots));
                visit(Pairing::of(own, shown, measured, self.limit_hz));
            }
        }
        Ok(())
    }

    /// The roots of those measured with target `nth`, where it matters what all of them share.
    pub(super) fn others_of<'a>(
        &'a self,
        nth: usize,
        roots: &'a [Roots],
    ) -> impl Iterator<Item = &'a [f64]> {
        let there = self.others[nth].iter().filter(|&&o| roots[o].present);
        there.map(|&o| roots[o].hz.as_slice())
    }

    /// The roots of each target; of one without values only if others are compared with it.
    pub(super) fn find_roots(&self, formed: &mut Formed<'_>) -> Result<()> {
        for (nth, target) in self.targets.iter().enumerate() {
            let Roots {
                hz,
                cancelled_hz,
                present,
            } = &mut formed.roots[nth];
            hz.clear();
            cancelled_hz.clear();
            *present = false;
            if !self.connected[nth] || target.freq_hz.is_empty() && self.others[nth].is_empty() {
                continue;
            }
            let query = Query {
                route: Route::Modal,
                f_max_hz: self.limit_hz,
                include_cancelled: target.sees != Sees::Frf,
            };
            let ends = (target.dof, target.excitation);
            let found = formed.prepared.find(ends.0, ends.1, &query, hz)?;
            *present = found == Transfer::Present;
            if query.include_cancelled && *present {
                formed.prepared.cancelled(cancelled_hz);
            }
        }
        Ok(())
    }

    /// J(x). Where the eigenproblem fails, every measured value counts as unpaired, so that J stays
    /// finite for every x in bounds.
    pub(super) fn value(&self, x: &[f64], ws: &mut Workspace) -> f64 {
        let snapped = self.unknowns.snapped(x);
        let mut misfit = 0.0;
        let mut weights = self.weights.iter();
        let solved = self.each_pair(&mut self.form(&snapped, ws), |pairing| {
            let weight = weights.next().copied().unwrap_or(1.0);
            misfit = self.misfit.add(misfit, weight * pairing.residual);
        });
        if solved.is_err() {
            misfit = self
                .weights
                .iter()
                .fold(0.0, |total, w| self.misfit.add(total, w * UNPAIRED));
        }
        misfit + self.unknowns.penalty_at(&snapped)
    }

    /// Norm of the residuals.
    pub(super) fn misfit(&self) -> Misfit {
        self.misfit
    }

    /// Each measured value with the number of its target and its weight.
    pub(super) fn measured(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let targets = self.targets.iter().enumerate();
        let values = targets.flat_map(|(nth, t)| t.freq_hz.iter().map(move |&freq| (nth, freq)));
        values.zip(&self.weights).map(|((t, f), &w)| (t, f, w))
    }

    /// Response and force of a target.
    pub(super) fn ends(&self, target: usize) -> (usize, usize) {
        let target = &self.targets[target];
        (target.dof, target.excitation)
    }
}

/// The targets with which transmissibilities were formed of target `nth`.
fn measured_with(targets: &[Target], nth: usize) -> Vec<usize> {
    let Target { sees, together, .. } = targets[nth];
    if sees != Sees::Transmissibility {
        return vec![];
    }
    let with = |other: &usize| *other != nth && targets[*other].together == together;
    (0..targets.len()).filter(with).collect()
}
