//! All roots that a measurement could show of the model at one x, and how they move.
//!
//! ```text
//! d ln f / dp = (dx/dp) / (2 x),  x = ω²
//! ```
//!
//! An objective asks for the partners of what was measured. Who compares two states of a structure (intact and
//! damaged) must follow the roots themselves, measured or not, from one state to the other.

use std::ops::{ControlFlow, RangeInclusive};

use super::objective::{AntiresonanceObjective, Workspace};
use super::sight::shown;
use crate::antiresonances::{ZeroBatch, ZeroSensitivity};
use crate::error::Result;
use crate::fem::slopes::MatrixSlopes;
use crate::modal::modes::eigenvalue;
use crate::optimize::outcome::Interrupt;
use crate::optimize::{Candidates, Objective, parallel_map};

/// Frequencies (Hz) between two limits.
pub type Band = RangeInclusive<f64>;

/// The roots of all targets at one x, target by target, ascending in each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Number of the target.
    pub target: Vec<u32>,
    /// Frequencies (Hz).
    pub freq_hz: Vec<f64>,
    /// How much the measurement shows of each, 0 to 1; see [`sight`](super::sight).
    pub shown: Vec<f64>,
    /// d ln f / dp, a row for each root; empty where it was not asked for. 0 where a root has no derivative, or
    /// lies outside of the band of which slopes were asked for.
    pub slopes: Vec<f64>,
}

impl AntiresonanceObjective {
    /// The roots at `x`, up to 1.5 times the highest measured frequency, with the slopes of those in the band
    /// `slopes_hz`, if any; none where the eigenproblem fails.
    pub fn state(&self, x: &[f64], ws: &mut Workspace, slopes_hz: Option<&Band>) -> State {
        self.state_of(x, ws, slopes_hz).unwrap_or_default()
    }

    fn state_of(&self, x: &[f64], ws: &mut Workspace, slopes_hz: Option<&Band>) -> Result<State> {
        let slopes = slopes_hz.map_or_else(Vec::new, |_| self.unknowns().slopes(x));
        let (mut state, mut batch) = (State::default(), ZeroBatch::default());
        self.each_root(x, ws, slopes_hz, |root| {
            root.put_into(&mut state);
            let first = state.slopes.len();
            state.slopes.resize(first + slopes.len(), 0.0);
            let Some(zero) = root.zero else { return };
            batch.push(zero, (first, eigenvalue(root.hz)));
            if batch.is_full() {
                put(&mut batch, &slopes, &mut state.slopes);
            }
        })?;
        put(&mut batch, &slopes, &mut state.slopes);
        Ok(state)
    }

    /// Every root at `x`, target by target; with the null vectors of those in `band`, if any.
    pub(super) fn each_root(
        &self,
        x: &[f64],
        ws: &mut Workspace,
        band: Option<&Band>,
        mut visit: impl FnMut(Root<'_>),
    ) -> Result<()> {
        let mut formed = self.form(x, ws);
        self.find_roots(&mut formed)?;
        let mut zero = ZeroSensitivity::default();
        for nth in 0..formed.roots.len() {
            let own = formed.roots[nth].hz.clone();
            for (root, &hz) in own.iter().enumerate() {
                let shown = shown(&own, root, self.others_of(nth, formed.roots));
                let inside = band.is_some_and(|band| band.contains(&hz));
                if inside {
                    let (ends, x) = (self.ends(nth), eigenvalue(hz));
                    if formed.roots[nth].cancelled_hz.contains(&hz) {
                        zero.set_cancelled(&mut formed.prepared, ends, x)?;
                    } else {
                        zero.set(&mut formed.prepared, ends, x)?;
                    }
                }
                let zero = inside.then_some(&zero);
                visit(Root {
                    target: nth,
                    hz,
                    shown,
                    zero,
                });
            }
        }
        Ok(())
    }
}

/// A root of a target, with its null vectors where those were asked for.
pub(super) struct Root<'a> {
    target: usize,
    hz: f64,
    shown: f64,
    pub zero: Option<&'a ZeroSensitivity>,
}

impl Root<'_> {
    /// Adds it to a state, without slopes.
    pub fn put_into(&self, state: &mut State) {
        state
            .target
            .push(u32::try_from(self.target).unwrap_or(u32::MAX));
        state.freq_hz.push(self.hz);
        state.shown.push(self.shown);
    }
}

/// Puts the slopes of the roots in the batch to their places, and empties it.
fn put(batch: &mut ZeroBatch<(usize, f64)>, slopes: &[MatrixSlopes], into: &mut [f64]) {
    for (p, along) in slopes.iter().enumerate() {
        batch.along(along, |(first, x), dx| {
            let slope = dx / (2.0 * x);
            // A double zero has no derivative.
            into[first + p] = if slope.is_finite() { slope } else { 0.0 };
        });
    }
    batch.clear();
}

/// [`AntiresonanceObjective::state`] of every candidate, in order.
///
/// # Errors
/// Where the threads cannot be started.
pub fn states(
    objective: &AntiresonanceObjective,
    candidates: Candidates<'_>,
    slopes_hz: Option<&Band>,
    threads: usize,
    should_stop: &mut dyn FnMut() -> Option<Interrupt>,
) -> Result<ControlFlow<Interrupt, Vec<State>>> {
    parallel_map(
        candidates.len(),
        threads,
        || objective.workspace(),
        |i, ws| objective.state(candidates.row(i), ws, slopes_hz),
        should_stop,
    )
}

#[cfg(test)]
mod tests {
    use super::{Band, State, states};
    use crate::fem::chain::mass_spring_chain;
    use crate::fem::parameters::{Parameter, Quantity};
    use crate::optimize::Candidates;
    use crate::update::misfit::Misfit;
    use crate::update::objective::{AntiresonanceObjective, Target};
    use std::ops::ControlFlow;

    const X: [f64; 3] = [0.2, 1.1, 0.9];

    fn objective() -> AntiresonanceObjective {
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
        let target = |dof| Target {
            dof,
            freq_hz: vec![40.0, 90.0],
            ..Target::default()
        };
        AntiresonanceObjective::new(
            model,
            quantities.map(parameter).to_vec(),
            (0..3).map(target).collect(),
            Misfit::Absolute,
            None,
            0.0,
        )
        .unwrap()
    }

    fn at(rows: &[f64], threads: usize) -> Vec<State> {
        within(0.0..=f64::INFINITY, rows, threads)
    }

    fn within(band: Band, rows: &[f64], threads: usize) -> Vec<State> {
        let found = states(
            &objective(),
            Candidates::new(rows, 3),
            Some(&band),
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
        let here = &at(&X, 1)[0];
        assert!(here.freq_hz.len() >= 5 && here.target.last() == Some(&2));
        for p in 0..3 {
            let mut rows = [X, X].concat();
            rows[p] -= STEP;
            rows[3 + p] += STEP;
            let both = at(&rows, 2);
            for (root, hz) in here.freq_hz.iter().enumerate() {
                let difference =
                    (both[1].freq_hz[root] - both[0].freq_hz[root]) / (2.0 * STEP * hz);
                let slope = here.slopes[3 * root + p];
                assert!((slope - difference).abs() < 1e-8, "{slope} {difference}");
            }
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let rows: Vec<f64> = (0..20)
            .flat_map(|i| [0.04 * f64::from(i), 1.0, 1.0])
            .collect();
        assert_eq!(at(&rows, 1), at(&rows, 2));
    }

    #[test]
    fn slopes_are_told_in_the_band_only() {
        let (all, some) = (&at(&X, 1)[0], &within(30.0..=60.0, &X, 1)[0]);
        assert_eq!(all.freq_hz, some.freq_hz);
        for (nth, hz) in all.freq_hz.iter().enumerate() {
            let own = &some.slopes[3 * nth..3 * nth + 3];
            if (30.0..=60.0).contains(hz) {
                assert_eq!(own, &all.slopes[3 * nth..3 * nth + 3]);
            } else {
                assert_eq!(own, [0.0; 3]);
            }
        }
        assert!(all.freq_hz.iter().any(|hz| *hz > 60.0) && all.freq_hz.iter().any(|hz| *hz < 60.0));
    }
}
