//! The step of a descent: the residuals' linear model minimized over a box.
//!
//! ```text
//! min_d  Σ |e_i + (A d)_i| + cᵀ d    or    Σ (e_i + (A d)_i)² + cᵀ d,        low <= d <= high
//! ```
//!
//! by a primal-dual interior point method. With r = e + A d = u − v and y the slope of the norm at r, the
//! conditions are, for Σ |r|, u (1 − y) = v (1 + y) = μ, and for Σ r², y = 2 r; in both
//! c + Aᵀ y = z_l − z_h with z_l (d − low) = z_h (high − d) = μ. Eliminating all but Δd leaves
//!
//! ```text
//! (Aᵀ W A + Z) Δd = rhs,   W = 1 / (u/(1 − y) + v/(1 + y))  or  2,   Z = z_l/(d − low) + z_h/(high − d)
//! ```
//!
//! n x n and positive definite. The start satisfies every equation but the products, and so do all
//! iterates; Mehrotra's predictor chooses μ and the correction of second order.
//!
//! S. Portnoy & R. Koenker, The Gaussian hare and the Laplacian tortoise, Statist. Sci. 12 (1997) 279-300;
//! S. Mehrotra, SIAM J. Optim. 2 (1992) 575-601.

use super::super::composition::Norm;
use super::cholesky::Factor;
use super::subproblem::Subproblem;

/// Most iterations; some 15 are typical.
const MOST_ITERATIONS: usize = 50;

/// Duality gap, relative to the cost at the start, at which the step is found: squares count as such.
const GAP: (f64, f64) = (1e-10, 1e-18);

/// A component this near to a bound, relative to the box, lies on it.
const ON_BOUND: f64 = 1e-7;

/// The iterate.
struct Point {
    d: Vec<f64>,
    /// Slopes of the norm, y.
    y: Vec<f64>,
    /// The positive and the negative part of each residual, both kept above zero; for Σ |r| only.
    u: Vec<f64>,
    v: Vec<f64>,
    z_low: Vec<f64>,
    z_high: Vec<f64>,
}

/// A direction for each part of the [`Point`].
type Direction = Point;

impl Subproblem<'_> {
    /// The step; inside the box, to the tolerance of the gap.
    pub(super) fn solve(&self) -> Vec<f64> {
        let mut at = self.start();
        let n = at.d.len();
        let (products, tolerance) = match self.norm {
            Norm::Absolute => (2 * (at.u.len() + n), GAP.0),
            Norm::Squared => (2 * n, GAP.1),
        };
        let value = self.value(&vec![0.0; n]).abs();
        let mut last_gap = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            let gap = self.gap(&at, None);
            if gap <= tolerance * value || gap >= last_gap * 0.999 {
                break;
            }
            last_gap = gap;
            let Some(factor) = Factor::of(self.normal_matrix(&at), n) else {
                break;
            };
            let affine = self.direction(&at, &factor, 0.0, None);
            let reached = self.gap(&at, Some((&affine, self.length(&at, &affine).min(1.0))));
            let mu = (reached / gap).powi(3) * gap / products as f64;
            let direction = self.direction(&at, &factor, mu, Some(&affine));
            let length = (0.995 * self.length(&at, &direction)).min(1.0);
            at.advance(&direction, length);
        }
        for j in 0..n {
            let width = self.high[j] - self.low[j];
            if at.d[j] - self.low[j] <= ON_BOUND * width {
                at.d[j] = self.low[j];
            } else if self.high[j] - at.d[j] <= ON_BOUND * width {
                at.d[j] = self.high[j];
            }
        }
        at.d
    }

    fn start(&self) -> Point {
        let n = self.low.len();
        let d: Vec<f64> = (0..n).map(|j| 0.5 * (self.low[j] + self.high[j])).collect();
        let r: Vec<f64> = self
            .residuals
            .iter()
            .zip(self.times(&d))
            .map(|(e, c)| e + c)
            .collect();
        let m = r.len();
        let room =
            r.iter().map(|r| r.abs()).sum::<f64>() / m.max(1) as f64 + f64::MIN_POSITIVE.sqrt();
        let (y, u, v) = match self.norm {
            Norm::Absolute => (
                vec![0.0; m],
                r.iter().map(|r| r.max(0.0) + room).collect(),
                r.iter().map(|r| (-r).max(0.0) + room).collect(),
            ),
            Norm::Squared => (r.iter().map(|r| 2.0 * r).collect(), vec![], vec![]),
        };
        // z_low − z_high = c + Aᵀ y, both positive.
        let g: Vec<f64> = self
            .transposed_times(&y)
            .iter()
            .zip(self.price)
            .map(|(a, c)| a + c)
            .collect();
        // Room for both, in the unit of the cost over the width of the box.
        let extra: Vec<f64> = (0..n)
            .map(|j| room * (1 + m) as f64 / (n as f64 * (self.high[j] - self.low[j])))
            .collect();
        Point {
            d,
            y,
            u,
            v,
            z_low: g
                .iter()
                .zip(&extra)
                .map(|(g, more)| g.max(0.0) + more)
                .collect(),
            z_high: g
                .iter()
                .zip(&extra)
                .map(|(g, more)| (-g).max(0.0) + more)
                .collect(),
        }
    }

    /// The sum of all products, at the point or as far along a direction as given.
    fn gap(&self, at: &Point, along: Option<(&Direction, f64)>) -> f64 {
        let moved = |x: f64, dx: fn(&Direction) -> &Vec<f64>, i: usize| {
            along.map_or(x, |(direction, length)| x + length * dx(direction)[i])
        };
        let mut gap = 0.0;
        for i in 0..at.u.len() {
            let y = moved(at.y[i], |d| &d.y, i);
            gap +=
                moved(at.u[i], |d| &d.u, i) * (1.0 - y) + moved(at.v[i], |d| &d.v, i) * (1.0 + y);
        }
        for j in 0..at.d.len() {
            let d = moved(at.d[j], |d| &d.d, j);
            gap += (d - self.low[j]) * moved(at.z_low[j], |d| &d.z_low, j)
                + (self.high[j] - d) * moved(at.z_high[j], |d| &d.z_high, j);
        }
        gap
    }

    fn weight(&self, at: &Point, i: usize) -> f64 {
        match self.norm {
            Norm::Absolute => (at.u[i] / (1.0 - at.y[i]) + at.v[i] / (1.0 + at.y[i])).recip(),
            Norm::Squared => 2.0,
        }
    }

    /// Aᵀ W A + Z, lower triangle of an n x n matrix, row by row.
    fn normal_matrix(&self, at: &Point) -> Vec<f64> {
        let n = at.d.len();
        let mut matrix = vec![0.0; n * n];
        for (i, row) in self.jacobian.chunks_exact(n).enumerate() {
            let weight = self.weight(at, i);
            for p in 0..n {
                let scaled = weight * row[p];
                for q in 0..=p {
                    matrix[p * n + q] += scaled * row[q];
                }
            }
        }
        for j in 0..n {
            matrix[j * n + j] +=
                at.z_low[j] / (at.d[j] - self.low[j]) + at.z_high[j] / (self.high[j] - at.d[j]);
        }
        matrix
    }

    /// Newton's direction to products μ, less the products of `second`'s own changes.
    fn direction(
        &self,
        at: &Point,
        factor: &Factor,
        mu: f64,
        second: Option<&Direction>,
    ) -> Direction {
        let (m, n) = (at.u.len(), at.d.len());
        let twice = |a: fn(&Direction) -> &Vec<f64>, b: fn(&Direction) -> &Vec<f64>, i: usize| {
            second.map_or(0.0, |s| a(s)[i] * b(s)[i])
        };
        // What each product u (1 − y), v (1 + y), (d − low) z_low, (high − d) z_high must still change by.
        let du: Vec<f64> = (0..m)
            .map(|i| mu - at.u[i] * (1.0 - at.y[i]) + twice(|s| &s.u, |s| &s.y, i))
            .collect();
        let dv: Vec<f64> = (0..m)
            .map(|i| mu - at.v[i] * (1.0 + at.y[i]) - twice(|s| &s.v, |s| &s.y, i))
            .collect();
        let dl: Vec<f64> = (0..n)
            .map(|j| mu - (at.d[j] - self.low[j]) * at.z_low[j] - twice(|s| &s.d, |s| &s.z_low, j))
            .collect();
        let dh: Vec<f64> = (0..n)
            .map(|j| {
                mu - (self.high[j] - at.d[j]) * at.z_high[j] + twice(|s| &s.d, |s| &s.z_high, j)
            })
            .collect();
        // W q, where u and v would move apart by q without any step.
        let pull: Vec<f64> = (0..m)
            .map(|i| self.weight(at, i) * (du[i] / (1.0 - at.y[i]) - dv[i] / (1.0 + at.y[i])))
            .collect();
        let mut d = if m == 0 {
            vec![0.0; n]
        } else {
            self.transposed_times(&pull)
        };
        for j in 0..n {
            d[j] += dl[j] / (at.d[j] - self.low[j]) - dh[j] / (self.high[j] - at.d[j]);
        }
        factor.solve(&mut d);
        let change = self.times(&d);
        let y: Vec<f64> = match self.norm {
            Norm::Absolute => (0..m)
                .map(|i| self.weight(at, i) * change[i] - pull[i])
                .collect(),
            Norm::Squared => change.iter().map(|c| 2.0 * c).collect(),
        };
        Direction {
            u: (0..m)
                .map(|i| (du[i] + at.u[i] * y[i]) / (1.0 - at.y[i]))
                .collect(),
            v: (0..m)
                .map(|i| (dv[i] - at.v[i] * y[i]) / (1.0 + at.y[i]))
                .collect(),
            z_low: (0..n)
                .map(|j| (dl[j] - at.z_low[j] * d[j]) / (at.d[j] - self.low[j]))
                .collect(),
            z_high: (0..n)
                .map(|j| (dh[j] + at.z_high[j] * d[j]) / (self.high[j] - at.d[j]))
                .collect(),
            d,
            y,
        }
    }

    /// How far the direction can be followed until a factor of a product reaches zero; at most 1e3.
    fn length(&self, at: &Point, direction: &Direction) -> f64 {
        let mut length = 1e3_f64;
        let mut limit = |value: f64, change: f64| {
            if change < 0.0 {
                length = length.min(-value / change);
            }
        };
        for i in 0..at.u.len() {
            limit(at.u[i], direction.u[i]);
            limit(at.v[i], direction.v[i]);
            limit(1.0 - at.y[i], -direction.y[i]);
            limit(1.0 + at.y[i], direction.y[i]);
        }
        for j in 0..at.d.len() {
            limit(at.d[j] - self.low[j], direction.d[j]);
            limit(self.high[j] - at.d[j], -direction.d[j]);
            limit(at.z_low[j], direction.z_low[j]);
            limit(at.z_high[j], direction.z_high[j]);
        }
        length
    }
}

impl Point {
    fn advance(&mut self, direction: &Direction, length: f64) {
        let pairs = [
            (&mut self.d, &direction.d),
            (&mut self.y, &direction.y),
            (&mut self.u, &direction.u),
            (&mut self.v, &direction.v),
            (&mut self.z_low, &direction.z_low),
            (&mut self.z_high, &direction.z_high),
        ];
        for (values, changes) in pairs {
            for (value, change) in values.iter_mut().zip(changes) {
                *value += length * change;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(norm: Norm, e: &[f64], a: &[f64], price: &[f64], reach: f64) -> Vec<f64> {
        let (low, high) = (vec![-reach; price.len()], vec![reach; price.len()]);
        let problem = Subproblem {
            norm,
            residuals: e,
            jacobian: a,
            price,
            low: &low,
            high: &high,
        };
        problem.solve()
    }

    #[test]
    fn one_unknown_goes_to_the_median_the_mean_or_the_end_of_the_box() {
        let (e, ones) = ([3.0, -1.0, 10.0, 2.0, 4.0], [1.0; 5]);
        let at = |norm, price, reach| solve(norm, &e, &ones, &[price], reach)[0];
        assert!((at(Norm::Absolute, 0.0, 20.0) + 3.0).abs() < 1e-8);
        // Σ (e + d)² + c d: d = −mean − c / 10.
        assert!((at(Norm::Squared, 5.0, 20.0) + 3.6 + 0.5).abs() < 1e-8);
        // Σ |e + d| + 2 d turns where one is above and three are below.
        assert!((at(Norm::Absolute, 2.0, 20.0) + 4.0).abs() < 1e-8);
        for norm in [Norm::Absolute, Norm::Squared] {
            assert_eq!(at(norm, 0.0, 1.0), -1.0);
        }
    }

    #[test]
    fn a_consistent_system_is_solved_whatever_the_flat_directions() {
        // Twelve residuals of four unknowns, the last two of which act as one.
        let a: Vec<f64> = (0..12)
            .flat_map(|i| {
                let at = |k: f64| (k * f64::from(i) + 0.3 * k).sin();
                [at(0.7), at(1.9), at(0.4), at(0.4)]
            })
            .collect();
        let truth = [0.3, -0.2, 0.15, 0.1];
        let e: Vec<f64> = a
            .chunks_exact(4)
            .map(|row| -row.iter().zip(truth).map(|(a, x)| a * x).sum::<f64>())
            .collect();
        for norm in [Norm::Absolute, Norm::Squared] {
            let d = solve(norm, &e, &a, &[0.0; 4], 1.0);
            assert!(
                (d[0] - 0.3).abs() < 1e-6 && (d[1] + 0.2).abs() < 1e-6,
                "{d:?}"
            );
            assert!((d[2] + d[3] - 0.25).abs() < 1e-6, "{d:?}");
        }
    }

    #[test]
    fn no_neighbour_of_a_step_is_better() {
        let a: Vec<f64> = (0..40).map(|i| (1.7 * f64::from(i * i)).cos()).collect();
        let e: Vec<f64> = (0..10).map(|i| (2.9 * f64::from(i)).sin()).collect();
        let price = [0.1, 0.3, 0.0, -0.2];
        for (norm, reach) in [
            (Norm::Absolute, 0.2),
            (Norm::Absolute, 5.0),
            (Norm::Squared, 5.0),
        ] {
            let (low, high) = ([-reach; 4], [reach; 4]);
            let problem = Subproblem {
                norm,
                residuals: &e,
                jacobian: &a,
                price: &price,
                low: &low,
                high: &high,
            };
            let d = problem.solve();
            let best = problem.value(&d);
            for k in 0..200 {
                let mut near = d.clone();
                for (j, x) in near.iter_mut().enumerate() {
                    let shift = 1e-3 * (f64::from(k) * 1.3 + 2.1 * j as f64).sin();
                    *x = (*x + shift).clamp(-reach, reach);
                }
                assert!(problem.value(&near) >= best - 1e-9, "{norm:?} {reach}");
            }
        }
    }
}
