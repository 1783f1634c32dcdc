//! The comparison objective: resonances and mode shapes.
//!
//! ```text
//! J = Σ |ω_A² / ω_E² − 1| + Σ (1 − MAC)² + γ₁ Σ β + γ₂ count(β > 0)        Eq. 18
//! ```
//!
//! over the measured modes, each with its partner of [`least_apart`]. Another [`Misfit`] replaces Σ|e|, the
//! shapes always count by their squares. A measured mode without a partner counts as one and one.
//!
//! Source: Meruane, J. Sound Vib. 332 (2013) 807-820.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::fem::assembly::Assembly;
use crate::fem::model::Model;
use crate::fem::parameters::Parameter;
use crate::modal::low_modes::LowModes;
use crate::modal::mac::Shape;
use crate::modal::modes::eigenvalue;
use crate::modal::solved::{Solutions, Solved};
use crate::modal::structure::Structure;

use super::misfit::Misfit;
use super::objective::BAND_MARGIN;
use super::pairing::{Partner, UNPAIRED, least_apart};
use super::penalties::Penalty;
use super::unknowns::{Unknowns, checked_weights};

/// One measured mode.
#[derive(Debug, Clone)]
pub struct MeasuredMode {
    /// Resonant frequency (Hz).
    pub freq_hz: f64,
    /// Its shape at the measured dofs.
    pub shape: Shape,
}

/// J(x) for one model, one parameter set and one set of measured modes.
pub struct ModalObjective {
    unknowns: Unknowns,
    measured: Vec<MeasuredMode>,
    misfit: Misfit,
    weights: Vec<f64>,
    limit: f64,
    structure: Arc<Structure>,
}

/// Working memory of one thread.
pub struct ModalWorkspace {
    assembly: Assembly,
    solutions: Solutions,
    modes: LowModes,
}

/// The model at one x with its modes.
pub(super) struct FormedModes<'a> {
    pub solved: Solved<'a>,
    pub modes: &'a mut LowModes,
}

impl ModalWorkspace {
    /// Mass-normalised shape of a partner found by the last [`ModalObjective::pairs`], one entry a dof.
    #[must_use]
    pub fn shape(&self, partner: Partner) -> &[f64] {
        self.modes.shape(partner.mode)
    }
}

impl ModalObjective {
    /// Joins a model, its parameters and a measurement; `penalty` and `snap` as of [`Unknowns::new`].
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when no mode was measured, one has no positive frequency or a dof outside the
    /// model; and those of [`Unknowns::new`].
    pub fn new(
        model: Model,
        parameters: Vec<Parameter>,
        measured: Vec<MeasuredMode>,
        misfit: Misfit,
        penalty: Option<Penalty>,
        snap: f64,
    ) -> Result<Self> {
        for (nth, mode) in measured.iter().enumerate() {
            if !(mode.freq_hz.is_finite() && mode.freq_hz > 0.0) {
                return Err(Error::input(
                    "measured",
                    format!("{} Hz of mode {nth}", mode.freq_hz),
                    "positive, finite frequencies",
                )
                .remedy("Leave rigid-body modes out."));
            }
            for &dof in mode.shape.dofs() {
                model.check_dof("measured", dof)?;
            }
        }
        let highest = measured.iter().fold(0.0_f64, |m, mode| m.max(mode.freq_hz));
        if highest == 0.0 {
            return Err(Error::input("measured", "no mode", "at least one")
                .remedy("Identify in a wider band."));
        }
        let unknowns = Unknowns::new(model, parameters, penalty, snap)?;
        let structure = Structure::under(&unknowns.model, &unknowns.parameters);
        structure.check_room()?;
        Ok(Self {
            structure: Arc::new(structure),
            unknowns,
            weights: vec![1.0; measured.len()],
            measured,
            misfit,
            limit: eigenvalue(BAND_MARGIN * highest),
        })
    }

    /// The same objective with both residuals of mode m, e and 1 − MAC, multiplied by `weights[m]`.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when there is not one finite, not negative weight for each mode, or all are
    /// zero.
    pub fn with_weights(mut self, weights: Vec<f64>) -> Result<Self> {
        self.weights = checked_weights(weights, self.measured.len())?;
        Ok(self)
    }

    /// The model and what may change in it.
    #[must_use]
    pub fn unknowns(&self) -> &Unknowns {
        &self.unknowns
    }

    /// The partner of each measured mode; its shape is that of the workspace's modes.
    ///
    /// # Errors
    /// Those of the eigenproblem.
    pub fn pairs(&self, x: &[f64], ws: &mut ModalWorkspace) -> Result<Vec<Option<Partner>>> {
        self.pairs_of(&mut self.form(x, ws))
    }

    /// New working memory.
    pub(super) fn memory(&self) -> ModalWorkspace {
        ModalWorkspace {
            assembly: Assembly::new(&self.unknowns.model),
            solutions: Solutions::new(&self.structure),
            modes: LowModes::default(),
        }
    }

    /// K(x) and M(x).
    pub(super) fn form<'a>(&self, x: &[f64], ws: &'a mut ModalWorkspace) -> FormedModes<'a> {
        let ModalWorkspace {
            assembly,
            solutions,
            modes,
        } = ws;
        assembly.form(&self.unknowns.model, &self.unknowns.parameters, x);
        FormedModes {
            solved: solutions.of(&assembly.stiffness, &assembly.mass),
            modes,
        }
    }

    /// [`pairs`](Self::pairs) of a model that is formed.
    pub(super) fn pairs_of(&self, formed: &mut FormedModes<'_>) -> Result<Vec<Option<Partner>>> {
        self.find_modes(formed)?;
        let modes = &*formed.modes;
        Ok(self
            .measured
            .iter()
            .map(|mode| {
                let mac = |r: usize| mode.shape.mac(modes.space(r), self.structure.n_dof());
                let measured = eigenvalue(mode.freq_hz);
                least_apart(modes.eigenvalues(), modes.zero(), measured, mac)
            })
            .collect())
    }

    /// The modes up to 1.5 times the highest measured frequency.
    pub(super) fn find_modes(&self, formed: &mut FormedModes<'_>) -> Result<()> {
        let start = self.measured[0].shape.dofs()[0];
        formed.modes.find(&mut formed.solved, self.limit, start)
    }

    /// Norm of the frequency residuals.
    pub(super) fn misfit(&self) -> Misfit {
        self.misfit
    }

    /// Each measured mode with its weight.
    pub(super) fn measured(&self) -> impl Iterator<Item = (&MeasuredMode, f64)> {
        self.measured.iter().zip(self.weights.iter().copied())
    }

    /// e and 1 − MAC of measured mode `m`, weighted.
    pub(super) fn residuals(&self, m: usize, partner: Option<Partner>) -> (f64, f64) {
        let (e, shape) = partner.map_or((UNPAIRED, UNPAIRED), |partner| {
            let e = partner.lambda / eigenvalue(self.measured[m].freq_hz) - 1.0;
            (e, 1.0 - partner.mac)
        });
        (self.weights[m] * e, self.weights[m] * shape)
    }

    /// J of those residuals at parameter values that are already snapped.
    pub(super) fn total(&self, residuals: &[(f64, f64)], snapped: &[f64]) -> f64 {
        let frequencies = residuals
            .iter()
            .fold(0.0, |total, (e, _)| self.misfit.add(total, *e));
        let shapes: f64 = residuals.iter().map(|(_, shape)| shape * shape).sum();
        frequencies + shapes + self.unknowns.penalty_at(snapped)
    }

    /// J(x). Where the eigenproblem fails, every measured mode counts as unpaired, so that J stays finite
    /// for every x in bounds.
    pub(super) fn value(&self, x: &[f64], ws: &mut ModalWorkspace) -> f64 {
        let snapped = self.unknowns.snapped(x);
        let pairs = self.pairs(&snapped, ws);
        let pairs = pairs.unwrap_or_else(|_| vec![None; self.measured.len()]);
        let residuals: Vec<(f64, f64)> = pairs
            .into_iter()
            .enumerate()
            .map(|(m, partner)| self.residuals(m, partner))
            .collect();
        self.total(&residuals, &snapped)
    }
}
