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
//!
//! # modal_linearization
//!
//! What the optimizer asks of the comparison objective: its cost and the first derivatives of its residuals.
//!
//! ```text
//! de/dp = (dλ_A/dp) / λ_E,   d(1 − MAC)/dp = −dMAC/dp
//! ```
//!
//! from [`crate::modal::mac`]; the pairing counts as fixed. Eq. 18 mixes absolute values of e with
//! squares of s = 1 − MAC. As s² is not negative it is its own absolute value, so Σ|e| + Σs² is the sum of
//! absolute values of the residuals e and s², the latter with the slope 2 s ds/dp; in the sum of squares the
//! residuals are e and s themselves.
//!
//! # modal_state
//!
//! All modes that a measurement could show of the model at one x, and how they move.
//!
//! ```text
//! d ln f / dp = (dλ/dp) / (2 λ),      du/dp of the shape at the measured dofs, |u| = 1
//! ```
//!
//! The counterpart of [`state`](crate::update::objective) for resonances. With P = I − u uᵀ at the measured dofs S,
//! du_d/dp = −z_dᵀ (dK/dp − λ dM/dp) φ for the slope P e_d / |φ_S|; see [`LowModes::adjoint`].
//!
//! [`LowModes::adjoint`]: crate::modal::modes::LowModes::adjoint

use std::sync::Arc;

use super::objective::BAND_MARGIN;
use super::pairing::{Partner, UNPAIRED, least_apart};
use super::unknowns::{Misfit, Penalty, Unknowns, checked_weights};
use crate::error::{Error, Result};
use crate::fem::assembly::{Assembly, MatrixSlopes};
use crate::fem::model::Model;
use crate::fem::parameters::Parameter;
use crate::modal::mac::{ModeSensitivity, Shape};
use crate::modal::modes::{LowModes, eigenvalue, hertz};
use crate::modal::solved::{Solutions, Solved};
use crate::modal::structure::Structure;
use crate::optimize::{Composition, Linearization, Objective};

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
    /// The model and what may change in it.
    pub unknowns: Unknowns,
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
struct FormedModes<'a> {
    solved: Solved<'a>,
    modes: &'a mut LowModes,
}

impl ModalWorkspace {
    /// Mass-normalised shape of a partner found by the last [`ModalObjective::pairs`], one entry a dof.
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
            return Err(
                Error::input("measured", "no mode", "at least one").remedy("Identify in a wider band.")
            );
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

    /// The same objective with both residuals of mode m, e and 1 − MAC, multiplied by `weights[m]`, by one
    /// without any.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when there is not one finite, not negative weight for each mode, or all are
    /// zero.
    pub fn with_weights(mut self, weights: Option<Vec<f64>>) -> Result<Self> {
        if let Some(weights) = weights {
            self.weights = checked_weights(weights, self.weights.len())?;
        }
        Ok(self)
    }

    /// The partner of each measured mode; its shape is that of the workspace's modes.
    pub fn pairs(&self, x: &[f64], ws: &mut ModalWorkspace) -> Result<Vec<Option<Partner>>> {
        self.pairs_of(&mut self.form(x, ws))
    }

    /// K(x) and M(x).
    fn form<'a>(&self, x: &[f64], ws: &'a mut ModalWorkspace) -> FormedModes<'a> {
        let ModalWorkspace { assembly, solutions, modes } = ws;
        assembly.form(&self.unknowns.model, &self.unknowns.parameters, x);
        FormedModes { solved: solutions.of(&assembly.stiffness, &assembly.mass), modes }
    }

    /// [`pairs`](Self::pairs) of a model that is formed.
    fn pairs_of(&self, formed: &mut FormedModes<'_>) -> Result<Vec<Option<Partner>>> {
        self.find_modes(formed)?;
        let modes = &*formed.modes;
        Ok(self
            .measured
            .iter()
            .map(|mode| {
                let mac = |r: usize| mode.shape.mac(modes.space(r), self.structure.n_dof());
                let measured = eigenvalue(mode.freq_hz);
                least_apart(&modes.lambda, modes.zero, measured, mac)
            })
            .collect())
    }

    /// The modes up to 1.5 times the highest measured frequency.
    fn find_modes(&self, formed: &mut FormedModes<'_>) -> Result<()> {
        let start = self.measured[0].shape.dofs()[0];
        formed.modes.find(&mut formed.solved, self.limit, start)
    }

    /// e and 1 − MAC of measured mode `m`, weighted.
    fn residuals(&self, m: usize, partner: Option<Partner>) -> (f64, f64) {
        let (e, shape) = partner.map_or((UNPAIRED, UNPAIRED), |partner| {
            let e = partner.lambda / eigenvalue(self.measured[m].freq_hz) - 1.0;
            (e, 1.0 - partner.mac)
        });
        (self.weights[m] * e, self.weights[m] * shape)
    }

    /// J of those residuals at parameter values that are already snapped.
    fn total(&self, residuals: &[(f64, f64)], snapped: &[f64]) -> f64 {
        let frequencies = residuals.iter().fold(0.0, |total, (e, _)| self.misfit.add(total, *e));
        let shapes: f64 = residuals.iter().map(|(_, shape)| shape * shape).sum();
        frequencies + shapes + self.unknowns.penalty_at(snapped)
    }
}

// ---- modal_linearization

impl Objective for ModalObjective {
    type Workspace = ModalWorkspace;

    fn workspace(&self) -> ModalWorkspace {
        ModalWorkspace {
            assembly: Assembly::new(&self.unknowns.model),
            solutions: Solutions::new(&self.structure),
            modes: LowModes::default(),
        }
    }

    /// J(x). Where the eigenproblem fails, every measured mode counts as unpaired, so that J stays finite
    /// for every x in bounds.
    fn cost(&self, x: &[f64], ws: &mut ModalWorkspace) -> f64 {
        let snapped = self.unknowns.snapped(x);
        let pairs = self.pairs(&snapped, ws);
        let pairs = pairs.unwrap_or_else(|_| vec![None; self.measured.len()]);
        let residuals: Vec<(f64, f64)> =
            pairs.into_iter().enumerate().map(|(m, partner)| self.residuals(m, partner)).collect();
        self.total(&residuals, &snapped)
    }

    fn composition(&self) -> Option<Composition> {
        Some(self.unknowns.composition(self.misfit.norm()))
    }

    /// J, its residuals, two for each measured mode, and their derivatives; `None` where the eigenproblem
    /// fails.
    fn linearize(&self, x: &[f64], ws: &mut ModalWorkspace) -> Option<Linearization> {
        let snapped = self.unknowns.snapped(x);
        let mut formed = self.form(&snapped, ws);
        let pairs = self.pairs_of(&mut formed).ok()?;
        let slopes = self.unknowns.slopes(&snapped);
        let (m, n) = (pairs.len(), slopes.len());
        let mut found =
            Linearization { cost: 0.0, residuals: Vec::with_capacity(2 * m), jacobian: vec![0.0; 2 * m * n] };
        let mut both = Vec::with_capacity(m);
        let mut mode = ModeSensitivity::default();
        for (nth, (measured, partner)) in self.measured.iter().zip(pairs).enumerate() {
            let (e, s) = self.residuals(nth, partner);
            both.push((e, s));
            // The residual that the norm knows, and its slope along s.
            let (shape, along) = match self.misfit {
                Misfit::Squared => (s, 1.0),
                Misfit::Absolute | Misfit::Largest => (s * s, 2.0 * s),
            };
            found.residuals.extend([e, shape]);
            let Some(partner) = partner else { continue };
            let (modes, solved) = (&*formed.modes, &mut formed.solved);
            mode.set(modes, solved, partner.mode, &measured.shape).ok()?;
            let rows = found.jacobian[2 * nth * n..].split_at_mut(n);
            for (index, slopes) in slopes.iter().enumerate() {
                let (lambda, mac) = mode.along(slopes);
                // Two modes all but repeated: the descent must not follow what is no number.
                let finite = |slope: f64| if slope.is_finite() { slope } else { 0.0 };
                rows.0[index] = finite(self.weights[nth] * lambda / eigenvalue(measured.freq_hz));
                rows.1[index] = finite(-along * self.weights[nth] * mac);
            }
        }
        found.cost = self.total(&both, &snapped);
        Some(found)
    }

    /// Negligible severities become exactly zero.
    fn repair(&self, x: &mut [f64]) {
        self.unknowns.snap(x);
    }
}

// ---- modal_state

/// A shape smaller than this at the measured dofs, relative to its largest entry, cannot be measured there.
const AT_REST: f64 = 1e-9;

/// The flexible modes at one x, ascending.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModalState {
    /// Frequencies (Hz).
    pub freq_hz: Vec<f64>,
    /// Shapes at [`ModalObjective::sensors`], of unit length there, one after the other.
    pub shapes: Vec<f64>,
    /// d ln f / dp, a row for each mode; empty where it was not asked for.
    pub slopes: Vec<f64>,
    /// du/dp, (modes, sensors, parameters); 0 for a repeated mode, whose shape has no derivative.
    pub shape_slopes: Vec<f64>,
}

impl ModalObjective {
    /// All dofs at which any mode was measured, ascending.
    pub fn sensors(&self) -> Vec<usize> {
        let of = self.measured.iter().flat_map(|mode| mode.shape.dofs());
        let mut dofs: Vec<usize> = of.copied().collect();
        dofs.sort_unstable();
        dofs.dedup();
        dofs
    }

    /// The modes at `x`, up to 1.5 times the highest measured frequency, without those at rest at all sensors;
    /// none where the eigenproblem fails.
    pub fn state(&self, x: &[f64], ws: &mut ModalWorkspace, with_slopes: bool) -> ModalState {
        self.state_of(x, ws, with_slopes).unwrap_or_default()
    }

    fn state_of(&self, x: &[f64], ws: &mut ModalWorkspace, with_slopes: bool) -> Result<ModalState> {
        let sensors = self.sensors();
        let mut formed = self.form(x, ws);
        self.find_modes(&mut formed)?;
        let slopes = if with_slopes { self.unknowns.slopes(x) } else { vec![] };
        let (modes, solved) = (&*formed.modes, &mut formed.solved);
        let mut state = ModalState::default();
        let mut adjoints = vec![vec![]; sensors.len()];
        for (r, &lambda) in modes.lambda.iter().enumerate() {
            let phi = modes.shape(r);
            let at: Vec<f64> = sensors.iter().map(|&dof| phi[dof]).collect();
            let size = at.iter().map(|a| a * a).sum::<f64>().sqrt();
            let largest = phi.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
            if lambda <= modes.zero || size <= AT_REST * largest {
                continue;
            }
            let unit: Vec<f64> = at.iter().map(|a| a / size).collect();
            state.freq_hz.push(hertz(lambda));
            state.shapes.extend_from_slice(&unit);
            if !with_slopes {
                continue;
            }
            let single = modes.space(r).len() == phi.len();
            for (d, z) in adjoints.iter_mut().enumerate().filter(|_| single) {
                let mut slope = vec![0.0; phi.len()];
                for (e, &dof) in sensors.iter().enumerate() {
                    let own = if d == e { 1.0 } else { 0.0 };
                    slope[dof] = (own - unit[d] * unit[e]) / size;
                }
                modes.adjoint(solved, r, &slope, z)?;
            }
            let moved: Vec<_> = slopes.iter().map(|along| moved(along, lambda, phi)).collect();
            let along = |load: &[(usize, f64)], left: &[f64]| {
                let slope: f64 = load.iter().map(|&(row, value)| left[row] * value).sum();
                if slope.is_finite() { slope } else { 0.0 }
            };
            let logs = moved.iter().map(|load| along(load, phi) / (2.0 * lambda));
            state.slopes.extend(logs);
            for z in &adjoints {
                let of = |load: &Vec<_>| if single { -along(load, z) } else { 0.0 };
                state.shape_slopes.extend(moved.iter().map(of));
            }
        }
        Ok(state)
    }
}

/// (dK/dp − λ dM/dp) φ, by the rows that are not zero.
fn moved(slopes: &MatrixSlopes, lambda: f64, phi: &[f64]) -> Vec<(usize, f64)> {
    let stiffness = slopes.stiffness.iter().map(|&(row, col, value)| (row, value * phi[col as usize]));
    let mass = slopes.mass.iter().map(|&(row, col, value)| (row, -lambda * value * phi[col as usize]));
    let mut rows: Vec<(usize, f64)> = Vec::new();
    for (row, value) in stiffness.chain(mass) {
        match rows.iter_mut().find(|(known, _)| *known == row as usize) {
            Some((_, total)) => *total += value,
            None => rows.push((row as usize, value)),
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::model::mass_spring_chain;
    use crate::fem::parameters::Quantity;
    use crate::optimize::{Candidates, evaluate_many};

    const X: [f64; 3] = [0.2, 1.1, 0.9];

    fn objective() -> ModalObjective {
        let model = mass_spring_chain(&[0.5, 0.4, 0.6, 0.3], &[5e4, 7e4, 4e4], 2e4, 0.0).unwrap();
        let quantities = [Quantity::StiffnessReduction, Quantity::StiffnessFactor, Quantity::MassFactor];
        let parameter = |quantity| Parameter { quantity, terms: vec![1] };
        let shape = Shape::new("measured", vec![3, 0, 1], &[(1.0, 0.0); 3]).unwrap();
        let mode = MeasuredMode { freq_hz: 90.0, shape };
        let parameters = quantities.map(parameter).to_vec();
        ModalObjective::new(model, parameters, vec![mode], Misfit::Absolute, None, 0.0).unwrap()
    }

    fn at(rows: &[f64], threads: usize) -> Vec<ModalState> {
        let state = |o: &ModalObjective, x: &[f64], ws: &mut ModalWorkspace| o.state(x, ws, true);
        let found = evaluate_many(&objective(), Candidates::new(rows, 3), threads, state, &mut || None);
        found.unwrap().continue_value().unwrap()
    }

    #[test]
    fn slopes_are_those_of_differences() {
        const STEP: f64 = 1e-5;
        assert_eq!(objective().sensors(), [0, 1, 3]);
        let here = &at(&X, 1)[0];
        assert!(here.freq_hz.len() >= 3 && here.shapes.len() == 3 * here.freq_hz.len());
        for p in 0..3 {
            let mut rows = [X, X].concat();
            rows[p] -= STEP;
            rows[3 + p] += STEP;
            let both = at(&rows, 2);
            for (r, hz) in here.freq_hz.iter().enumerate() {
                let log = (both[1].freq_hz[r] - both[0].freq_hz[r]) / (2.0 * STEP * hz);
                let slope = here.slopes[3 * r + p];
                assert!((slope - log).abs() < 1e-8, "{slope} {log}");
                let of = |state: &ModalState| state.shapes[3 * r..3 * r + 3].to_vec();
                // Shapes have either sign.
                let facing = |u: &[f64]| -> f64 { of(here).iter().zip(u).map(|(a, b)| a * b).sum() };
                let (low, high) = (of(&both[0]), of(&both[1]));
                let (before, after) = (facing(&low).signum(), facing(&high).signum());
                for d in 0..3 {
                    let difference = (after * high[d] - before * low[d]) / (2.0 * STEP);
                    let slope = here.shape_slopes[(3 * r + d) * 3 + p];
                    assert!((slope - difference).abs() < 1e-7, "{slope} {difference}");
                }
            }
        }
    }
}
