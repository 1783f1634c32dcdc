//! The roots of all targets at one x with their null vectors, for who joins these with changes of the model himself.
//!
//! ```text
//! dx/dp = leftᵀ (dK/dp − x dM/dp) right / slope,  x = ω²
//! ```
//!
//! On a reduced model dK/dp of a few elements is dense; of the full one it is not, and the null vectors of the
//! reduced model are those of the full one in few coordinates.

use super::objective::{AntiresonanceObjective, Workspace};
use super::state::{Band, State};

/// Roots, and a row of each null vector for each root; zeros, and a slope that is not finite, outside of the band.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NullVectors {
    /// The roots, without their slopes.
    pub state: State,
    /// Left null vectors, row by row.
    pub left: Vec<f64>,
    /// Right null vectors, row by row.
    pub right: Vec<f64>,
    /// leftᵀ M right of each root; not finite at a double zero.
    pub slope: Vec<f64>,
}

impl AntiresonanceObjective {
    /// The roots at `x` as of [`state`](Self::state) with the null vectors of those in the band; none where the
    /// eigenproblem fails.
    pub fn null_vectors(&self, x: &[f64], ws: &mut Workspace, band: &Band) -> NullVectors {
        let n = self.unknowns().n_dof();
        let mut found = NullVectors::default();
        let all = self.each_root(x, ws, Some(band), |root| {
            root.put_into(&mut found.state);
            let filled = found.left.len();
            if let Some(zero) = root.zero {
                let (left, right) = zero.vectors();
                found.left.extend_from_slice(left);
                found.right.extend_from_slice(right);
                found.slope.push(zero.slope());
            } else {
                found.slope.push(f64::NAN);
            }
            found.left.resize(filled + n, 0.0);
            found.right.resize(filled + n, 0.0);
        });
        all.map_or_else(|_| NullVectors::default(), |()| found)
    }
}

#[cfg(test)]
mod tests {
    use crate::fem::chain::mass_spring_chain;
    use crate::fem::parameters::{Parameter, Quantity};
    use crate::modal::modes::eigenvalue;
    use crate::optimize::Objective;
    use crate::update::misfit::Misfit;
    use crate::update::objective::{AntiresonanceObjective, Target};

    #[test]
    fn null_vectors_joined_with_a_term_are_the_slopes() {
        let model = mass_spring_chain(&[0.5, 0.4, 0.6, 0.3], &[5e4, 7e4, 4e4], 2e4, 0.0).unwrap();
        let spring = Parameter {
            quantity: Quantity::StiffnessFactor,
            terms: vec![1],
        };
        let targets = [0, 2].map(|dof| Target {
            dof,
            freq_hz: vec![40.0, 90.0],
            ..Target::default()
        });
        let objective = AntiresonanceObjective::new(
            model,
            vec![spring],
            targets.to_vec(),
            Misfit::Absolute,
            None,
            0.0,
        )
        .unwrap();
        let mut ws = objective.workspace();
        let band = 0.0..=70.0;
        let state = objective.state(&[1.1], &mut ws, Some(&band));
        let found = objective.null_vectors(&[1.1], &mut ws, &band);
        assert_eq!(found.state.freq_hz, state.freq_hz);
        assert!(state.slopes.iter().any(|slope| slope.abs() > 0.01));
        for (nth, &hz) in state.freq_hz.iter().enumerate() {
            let (left, right) = (&found.left[4 * nth..][..4], &found.right[4 * nth..][..4]);
            if hz > 70.0 {
                assert!(found.slope[nth].is_nan() && left == [0.0; 4] && right == [0.0; 4]);
                continue;
            }
            let change = 7e4 * (left[1] - left[2]) * (right[1] - right[2]);
            let slope = change / found.slope[nth] / (2.0 * eigenvalue(hz));
            assert!((slope - state.slopes[nth]).abs() < 1e-12);
        }
    }
}
