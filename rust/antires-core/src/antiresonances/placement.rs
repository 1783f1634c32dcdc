//! A root on the matrices themselves, where the modal series or QZ leaves it less exact than K and M tell it.
//!
//! The factors of K − xM come first ([`newton`](super::newton)). Where rounding spoils them, or where a pole so near
//! that the steps do not settle, two-sided Rayleigh quotients take over ([`rayleigh`](super::rayleigh)).

use super::newton::{Placed, by_factors};
use super::rayleigh::by_quotients;
use crate::modal::solved::Solved;

/// The root of H_ik nearest to `x` within `reach`; none where there is none.
pub(super) fn place(
    solved: &mut Solved<'_>,
    ends: (usize, usize),
    x: f64,
    reach: f64,
) -> Option<Placed> {
    let by_factors = by_factors(solved.reduced(), ends, x, reach);
    if by_factors.is_some() || !solved.may_be_dense() {
        return by_factors;
    }
    by_quotients((solved.stiffness(), solved.mass()), ends, x, reach)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use faer::Mat;

    use super::super::{Query, Route, antiresonances};
    use super::*;
    use crate::fem::chain::mass_spring_chain;
    use crate::fem::model::Model;
    use crate::modal::modes::eigenvalue;
    use crate::modal::reduced::ReducedModes;
    use crate::modal::structure::Structure;

    /// A stiff chain, its last mass on a soft spring.
    fn chain(n: usize) -> Model {
        mass_spring_chain(&vec![1.0; n], &vec![1e12; n - 1], 0.0, 1e2).unwrap()
    }

    fn band_of(model: &Model) -> ReducedModes {
        let mut band = ReducedModes::new(Arc::new(Structure::of(model)));
        band.set_matrices(model.stiffness(), model.mass());
        band
    }

    #[test]
    fn the_deleted_pencil_leads_to_the_closed_form() {
        let model = chain(60);
        let matrices = (model.stiffness(), model.mass());
        // Fixed at mass 30, the masses above it are a rod, fixed and free: 4 k sin²(π / (4 m + 2)).
        let m = 30.0_f64;
        let want = 4e12 * (std::f64::consts::PI / (4.0 * m + 2.0)).sin().powi(2);
        for start in [0.999 * want, 1.0008 * want] {
            let found = by_quotients(matrices, (30, 59), start, 2e-3 * want).unwrap();
            assert!((found.x / want - 1.0).abs() < 1e-12, "{found:?} {want}");
            assert!(found.ulp < 1e-12 * want);
            assert!(by_quotients(matrices, (30, 59), start, 1e-5 * want).is_none());
        }
        // No pivot of the band is sound there: the masses above are the first rows, and singular.
        assert!(by_factors(&mut band_of(&model), (30, 59), 0.999 * want, 2e-3 * want).is_none());
    }

    #[test]
    fn band_and_deleted_pencil_lead_to_one_root() {
        // Springs to the next mass and to the one after it.
        let joined = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 4.0 + 0.1 * (i as f64).sin(),
            1 | 2 => -1.0,
            _ => 0.0,
        };
        let stiffness = Mat::from_fn(50, 50, |i, j| 1e4 * joined(i, j));
        let mass = Mat::from_fn(50, 50, |i, j| f64::from(u8::from(i == j)));
        let model = Model::new(stiffness, mass, vec![], vec![]).unwrap();
        let (matrices, mut band) = ((model.stiffness(), model.mass()), band_of(&model));
        let query = Query {
            route: Route::Modal,
            f_max_hz: f64::INFINITY,
            include_cancelled: false,
        };
        let roots = &antiresonances(&model, &[17], 30, &query).unwrap()[0].freq_hz;
        assert!(roots.len() > 20);
        let mut settled = 0;
        for want in roots.iter().map(|&f| eigenvalue(f)) {
            let (start, reach) = (want * (1.0 + 1e-6), 1e-5 * want);
            let deleted = by_quotients(matrices, (17, 30), start, reach).unwrap();
            assert!((deleted.x / want - 1.0).abs() < 1e-11);
            if let Some(found) = by_factors(&mut band, (17, 30), start, reach) {
                settled += 1;
                assert!((found.x / deleted.x - 1.0).abs() < 1e-11);
            }
        }
        assert!(2 * settled > roots.len(), "{settled}");
    }

    #[test]
    fn where_there_is_no_root_none_is_made() {
        let model = chain(60);
        let (matrices, mut band) = ((model.stiffness(), model.mass()), band_of(&model));
        // The transfer from end to end of a chain has no zero.
        for x in [1.0, 1e6, 1e11, 1e13] {
            assert!(by_factors(&mut band, (0, 59), x, 1e-2 * x).is_none());
            assert!(by_quotients(matrices, (0, 59), x, 1e-2 * x).is_none());
        }
    }
}
