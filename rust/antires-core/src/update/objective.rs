//! The antiresonance objective J(x).

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::fem::model::{Model, connected};
use crate::fem::parameters::{Assembly, Parameter};
use crate::modal::antiresonances::{AntiresonanceSolver, Query, Route};
use crate::modal::structure::Structure;
use crate::optimize::{Composition, Linearization, Objective};

use super::misfit::Misfit;
use super::pairing::{Pairing, UNPAIRED};
use super::penalties::Penalty;
use super::unknowns::{Unknowns, checked_weights};

/// The model's antiresonances are computed to this multiple of the highest measured frequency, so
/// that the edge of the band cuts off no partner.
pub const BAND_MARGIN: f64 = 1.5;

/// Measured antiresonances of one response to one force.
#[derive(Debug, Clone)]
pub struct Target {
    /// Response dof.
    pub dof: usize,
    /// Dof of the force.
    pub excitation: usize,
    /// Antiresonant frequencies (Hz).
    pub freq_hz: Vec<f64>,
}

/// J(x) for one model, one parameter set and one measurement.
pub struct AntiresonanceObjective {
    pub(super) unknowns: Unknowns,
    pub(super) targets: Vec<Target>,
    pub(super) misfit: Misfit,
    query: Query,
    structure: Arc<Structure>,
    connected: Vec<bool>,
    pub(super) weights: Vec<f64>,
}

/// Working memory of one thread.
pub struct Workspace {
    pub(super) assembly: Assembly,
    pub(super) solver: AntiresonanceSolver,
    analytic_hz: Vec<f64>,
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
        let structure = Arc::new(Structure::of(model));
        Ok(Self {
            structure,
            unknowns,
            targets,
            misfit,
            query: Query {
                route: Route::Modal,
                f_max_hz: BAND_MARGIN * highest,
                include_cancelled: false,
            },
            connected,
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

    /// The analytic partner of each measured value and its residual, target by target.
    ///
    /// # Errors
    /// Those of the eigenproblem.
    pub fn pairs(&self, x: &[f64], ws: &mut Workspace) -> Result<Vec<Pairing>> {
        let mut out = Vec::new();
        self.each_pair(x, ws, |pairing| out.push(pairing))?;
        Ok(out)
    }

    fn each_pair(
        &self,
        x: &[f64],
        ws: &mut Workspace,
        mut visit: impl FnMut(Pairing),
    ) -> Result<()> {
        let Unknowns {
            model, parameters, ..
        } = &self.unknowns;
        ws.assembly.form(model, parameters, x);
        ws.solver
            .set_matrices(ws.assembly.stiffness.as_ref(), ws.assembly.mass.as_ref());
        for (target, &connected) in self.targets.iter().zip(&self.connected) {
            ws.analytic_hz.clear();
            if connected && !target.freq_hz.is_empty() {
                ws.solver.find(
                    (ws.assembly.stiffness.as_ref(), ws.assembly.mass.as_ref()),
                    target.dof,
                    target.excitation,
                    &self.query,
                    &mut ws.analytic_hz,
                )?;
            }
            for &measured in &target.freq_hz {
                visit(Pairing::of(&ws.analytic_hz, measured, self.query.f_max_hz));
            }
        }
        Ok(())
    }
}

impl Objective for AntiresonanceObjective {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        Workspace {
            assembly: Assembly::new(&self.unknowns.model),
            solver: AntiresonanceSolver::new(&self.structure),
            analytic_hz: Vec::with_capacity(self.unknowns.model.n_dof()),
        }
    }

    /// J(x). Where the eigenproblem fails, every measured value counts as unpaired, so that J stays
    /// finite for every x in bounds.
    fn cost(&self, x: &[f64], ws: &mut Workspace) -> f64 {
        let snapped = self.unknowns.snapped(x);
        let mut misfit = 0.0;
        let mut weights = self.weights.iter();
        let solved = self.each_pair(&snapped, ws, |pairing| {
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

    fn composition(&self) -> Option<Composition> {
        Some(self.unknowns.composition(self.misfit.norm()))
    }

    fn linearize(&self, x: &[f64], ws: &mut Workspace) -> Option<Linearization> {
        self.linearized(x, ws)
    }

    /// Negligible severities become exactly zero.
    fn repair(&self, x: &mut [f64]) {
        self.unknowns.snap(x);
    }
}
