//! All modes that a measurement could show of the model at one x, and how they move.
//!
//! ```text
//! d ln f / dp = (dλ/dp) / (2 λ),      du/dp of the shape at the measured dofs, |u| = 1
//! ```
//!
//! The counterpart of [`state`](super::state) for resonances. With P = I − u uᵀ at the measured dofs S,
//! du_d/dp = −z_dᵀ (dK/dp − λ dM/dp) φ for the slope P e_d / |φ_S|; see [`LowModes::adjoint`].
//!
//! [`LowModes::adjoint`]: crate::modal::low_modes::LowModes::adjoint

use std::ops::ControlFlow;

use super::modal_objective::{ModalObjective, ModalWorkspace};
use crate::error::Result;
use crate::fem::slopes::MatrixSlopes;
use crate::modal::modes::hertz;
use crate::optimize::outcome::Interrupt;
use crate::optimize::{Candidates, Objective, parallel_map};

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
    #[must_use]
    pub fn sensors(&self) -> Vec<usize> {
        let of = self.measured().flat_map(|(mode, _)| mode.shape.dofs());
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

    fn state_of(
        &self,
        x: &[f64],
        ws: &mut ModalWorkspace,
        with_slopes: bool,
    ) -> Result<ModalState> {
        let sensors = self.sensors();
        let mut formed = self.form(x, ws);
        self.find_modes(&mut formed)?;
        let slopes = if with_slopes {
            self.unknowns().slopes(x)
        } else {
            vec![]
        };
        let (modes, solved) = (&*formed.modes, &mut formed.solved);
        let mut state = ModalState::default();
        let mut adjoints = vec![vec![]; sensors.len()];
        for (r, &lambda) in modes.eigenvalues().iter().enumerate() {
            let phi = modes.shape(r);
            let at: Vec<f64> = sensors.iter().map(|&dof| phi[dof]).collect();
            let size = at.iter().map(|a| a * a).sum::<f64>().sqrt();
            let largest = phi.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
            if lambda <= modes.zero() || size <= AT_REST * largest {
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
            let moved: Vec<_> = slopes
                .iter()
                .map(|along| moved(along, lambda, phi))
                .collect();
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
    let stiffness = slopes
        .stiffness
        .iter()
        .map(|&(row, col, value)| (row, value * phi[col as usize]));
    let mass = slopes
        .mass
        .iter()
        .map(|&(row, col, value)| (row, -lambda * value * phi[col as usize]));
    let mut rows: Vec<(usize, f64)> = Vec::new();
    for (row, value) in stiffness.chain(mass) {
        match rows.iter_mut().find(|(known, _)| *known == row as usize) {
            Some((_, total)) => *total += value,
            None => rows.push((row as usize, value)),
        }
    }
    rows
}

/// [`ModalObjective::state`] of every candidate, in order.
///
/// # Errors
/// Where the threads cannot be started.
pub fn modal_states(
    objective: &ModalObjective,
    candidates: Candidates<'_>,
    with_slopes: bool,
    threads: usize,
    should_stop: &mut dyn FnMut() -> Option<Interrupt>,
) -> Result<ControlFlow<Interrupt, Vec<ModalState>>> {
    parallel_map(
        candidates.len(),
        threads,
        || objective.workspace(),
        |i, ws| objective.state(candidates.row(i), ws, with_slopes),
        should_stop,
    )
}

#[cfg(test)]
mod tests {
    use super::{ModalState, modal_states};
    use crate::fem::chain::mass_spring_chain;
    use crate::fem::parameters::{Parameter, Quantity};
    use crate::modal::mac::Shape;
    use crate::optimize::Candidates;
    use crate::update::misfit::Misfit;
    use crate::update::modal_objective::{MeasuredMode, ModalObjective};
    use std::ops::ControlFlow;

    const X: [f64; 3] = [0.2, 1.1, 0.9];

    fn objective() -> ModalObjective {
        let model = mass_spring_chain(&[0.5, 0.4, 0.6, 0.3], &[5e4, 7e4, 4e4], 2e4, 0.0).unwrap();
        let quantities = [
            Quantity::StiffnessReduction,
            Quantity::StiffnessFactor,
            Quantity::MassFactor,
        ];
        let parameter = |quantity| Parameter {
            quantity,
            terms: vec![1],
        };
        let shape = Shape::new("measured", vec![3, 0, 1], &[(1.0, 0.0); 3]).unwrap();
        let mode = MeasuredMode {
            freq_hz: 90.0,
            shape,
        };
        let parameters = quantities.map(parameter).to_vec();
        ModalObjective::new(model, parameters, vec![mode], Misfit::Absolute, None, 0.0).unwrap()
    }

    fn at(rows: &[f64], threads: usize) -> Vec<ModalState> {
        let found = modal_states(
            &objective(),
            Candidates::new(rows, 3),
            true,
            threads,
            &mut || None,
        );
        match found.unwrap() {
            ControlFlow::Continue(found) => found,
            ControlFlow::Break(_) => panic!("nobody stopped it"),
        }
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
                let facing =
                    |u: &[f64]| -> f64 { of(here).iter().zip(u).map(|(a, b)| a * b).sum() };
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
