//! Minors of the receptance matrix: det H[I, J] of r responses I and r forces J.
//!
//! ```text
//! H_ik(x) = d_ik + t(x) Σ_m ψ_im γ_km / (λ_m − x)             t = 1, ψ = γ = φ; or t = x + σ, d = H(−σ)
//! det H[I, J](x) / t(x) = Σ_m R_m / (λ_m − x) + ...           R_m = γ_mᵀ adj(G_m(λ_m)) ψ_m
//! ```
//!
//! with G_m = H[I, J] without mode m. By Jacobi's identity the minor is ± det A(J, I deleted) / det A of A = K − xM:
//! where eigenvalues are distinct its poles are simple, whatever r. So it has the partial fractions of a receptance
//! with other residues, and its zeros are isolated by the same proof
//! ([`secular`](crate::antiresonances)). R_m is the bordered determinant −det [G_m, ψ_m; γ_mᵀ, 0] (Sylvester).
//!
//! Eigenvalues that coincide make poles of higher order. They are *spread* by 1e-7 first: roots far from them move
//! by as little, and [`refined`](MinorSeries::refined) takes them back. Of p modes of one λ, as many roots cancel as
//! the bordered matrix of all p has null vectors; those that the spread puts between the poles count for no more.
//!
//! Near some poles Λ, with their modes Ψ, Γ taken out of G, a root is where
//!
//! ```text
//! B(x) = [G(x), Ψ; Γᵀ, −(Λ − x)/t]         det B = ± det H[I, J] · Π (Λ − x) / t
//! ```
//!
//! is singular. B has no pole there, so that a root is refined beside a pole, or on it, as anywhere else:
//! x ← x − bᵀB c / bᵀB'c with its null vectors b, c. They also combine the columns of (K − xM)⁻¹ to the null vectors
//! of the deleted pencil.

use std::ops::Range;

use super::receptance::{Receptance, ulps};
use crate::error::{Error, Result};
use crate::linalg::symmetric::SymmetricSolver;
use crate::linalg::wide::{LANES, total};

/// Most forces at a time.
pub const MOST_FORCES: usize = 4;

/// Rows of the largest bordered matrix: the forces and as many modes as are left.
const BORDERED: usize = 2 * MOST_FORCES;

/// Relative distance to which coinciding eigenvalues are spread.
const SPREAD: f64 = 1e-7;

/// Multiple of it within which eigenvalues are a group.
const IN_GROUP: f64 = 8.0;

/// Relative distance within which they are one.
const ONE_POLE: f64 = 1e-9;

/// Below this fraction of the largest residue a pole is cancelled, as of a receptance.
const NEGLIGIBLE_RESIDUE: f64 = 1e-12;

/// Multiple of its error from which on a residue is not rounding.
const SURE_RESIDUE: f64 = 16.0;

/// Last pivot, relative to the largest, below which a bordered matrix at a pole is singular.
const SINGULAR: f64 = 1e-8;

/// Relative distance in x of the poles that are bordered, and most steps of a refinement.
const BESIDE: f64 = 1e-3;
const MOST_STEPS: usize = 12;

/// Relative step that ends it, and farthest way, that of a spread group beside a root.
const SETTLED: f64 = 1e-14;
const FARTHEST: f64 = 1e-4;

/// r responses and r forces, of which one are those of H_ik.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ends {
    order: usize,
    responses: [usize; MOST_FORCES],
    forces: [usize; MOST_FORCES],
}

impl Default for Ends {
    fn default() -> Self {
        Self::from((0, 0))
    }
}

impl From<(usize, usize)> for Ends {
    fn from((response, force): (usize, usize)) -> Self {
        let (mut responses, mut forces) = ([0; MOST_FORCES], [0; MOST_FORCES]);
        (responses[0], forces[0]) = (response, force);
        Self { order: 1, responses, forces }
    }
}

impl Ends {
    /// As many responses as forces, none twice.
    pub fn new(responses: &[usize], forces: &[usize]) -> Result<Self> {
        let r = forces.len();
        if !(1..=MOST_FORCES).contains(&r) {
            return Err(Error::input(
                "excitation",
                format!("{r} dofs"),
                format!("one to {MOST_FORCES} forces"),
            )
            .remedy("Name the dofs of the forces that act together."));
        }
        if responses.len() != r {
            return Err(Error::input(
                "response",
                format!("{} dofs for {r} forces", responses.len()),
                "as many responses as forces",
            )
            .remedy("An antiresonance of order r belongs to r responses and r forces."));
        }
        for (name, dofs) in [("response", responses), ("excitation", forces)] {
            if let Some(twice) = (1..r).find(|&j| dofs[..j].contains(&dofs[j])) {
                return Err(Error::input(name, format!("dof {} twice", dofs[twice]), "distinct dofs")
                    .remedy("Leave one of the two out, and one of the forces or responses with it."));
            }
        }
        let mut ends = Self { order: r, responses: [0; MOST_FORCES], forces: [0; MOST_FORCES] };
        ends.responses[..r].copy_from_slice(responses);
        ends.forces[..r].copy_from_slice(forces);
        Ok(ends)
    }

    /// Dofs of the responses.
    pub fn responses(&self) -> &[usize] {
        &self.responses[..self.order]
    }

    /// Dofs of the forces.
    pub fn forces(&self) -> &[usize] {
        &self.forces[..self.order]
    }

    /// Response and force, where there is one of each.
    pub fn pair(&self) -> Option<(usize, usize)> {
        (self.order == 1).then_some((self.responses[0], self.forces[0]))
    }
}

/// One number for each response or force.
pub type Each = [f64; MOST_FORCES];

// ---- small matrices

/// A small square matrix.
#[derive(Debug, Clone, Copy)]
pub struct Small {
    n: usize,
    /// Its entries, row by row.
    pub a: [[f64; BORDERED]; BORDERED],
}

/// Vectors on which a small matrix is all but zero: bᵀ B c = `value`.
#[derive(Debug, Clone, Copy)]
pub struct Null {
    /// c.
    pub right: [f64; BORDERED],
    /// b.
    pub left: [f64; BORDERED],
    /// Last pivot.
    pub value: f64,
    /// Number of pivots that vanish beside the largest, of the matrix with rows and columns of one size.
    pub nullity: usize,
}

impl Small {
    /// The zero matrix of `n` rows.
    pub fn zeros(n: usize) -> Self {
        Self { n, a: [[0.0; BORDERED]; BORDERED] }
    }

    /// The matrix with one more row and column, and zero in the corner.
    fn bordered(&self, column: &Each, row: &Each) -> Self {
        let (n, mut out) = (self.n, *self);
        out.n = n + 1;
        for i in 0..n {
            (out.a[i][n], out.a[n][i]) = (column[i], row[i]);
        }
        out.a[n][n] = 0.0;
        out
    }

    /// Its determinant, by elimination.
    fn determinant(mut self) -> f64 {
        let n = self.n;
        let mut product = 1.0;
        for j in 0..n {
            let pivot = (j..n).fold(j, |p, i| if self.a[i][j].abs() > self.a[p][j].abs() { i } else { p });
            if self.a[pivot][j] == 0.0 {
                return 0.0;
            }
            if pivot != j {
                self.a.swap(pivot, j);
                product = -product;
            }
            product *= self.a[j][j];
            for i in j + 1..n {
                let factor = self.a[i][j] / self.a[j][j];
                for c in j + 1..n {
                    self.a[i][c] -= factor * self.a[j][c];
                }
            }
        }
        product
    }

    /// Sum of the moduli of all products that its determinant consists of.
    fn permanent(&self) -> f64 {
        self.expanded(0, 0)
    }

    fn expanded(&self, row: usize, taken: u32) -> f64 {
        if row == self.n {
            return 1.0;
        }
        let free = (0..self.n).filter(|c| taken & (1 << c) == 0 && self.a[row][*c] != 0.0);
        free.map(|c| self.a[row][c].abs() * self.expanded(row + 1, taken | 1 << c)).sum()
    }

    /// γᵀ adj(A) ψ of two rows with sign −1; with sign 1, of what is not negative, the sum of all its products.
    fn of_two(&self, psi: &Each, gamma: &Each, sign: f64) -> f64 {
        let a = &self.a;
        gamma[0] * (a[1][1] * psi[0] + sign * a[0][1] * psi[1])
            + gamma[1] * (a[0][0] * psi[1] + sign * a[1][0] * psi[0])
    }

    /// bᵀ A c.
    fn form(&self, b: &[f64], c: &[f64]) -> f64 {
        (0..self.n).map(|i| b[i] * (0..self.n).map(|j| self.a[i][j] * c[j]).sum::<f64>()).sum()
    }

    /// Null vectors, by elimination with pivots from the whole rest. Rows and columns are brought to one size by
    /// those of `size`, the moduli that the entries are sums of: a column that vanishes must not be brought to any.
    pub fn null(&self, size: Option<&Self>) -> Null {
        let n = self.n;
        let (mut u, mut rows, mut cols) = (self.a, [1.0; BORDERED], [1.0; BORDERED]);
        if let Some(Self { a: size, .. }) = size {
            let unit = |largest: f64| if largest > 0.0 { largest.log2().round().exp2().recip() } else { 1.0 };
            for i in 0..n {
                rows[i] = unit((0..n).fold(0.0, |m: f64, j| m.max(size[i][j])));
            }
            for j in 0..n {
                cols[j] = unit((0..n).fold(0.0, |m: f64, i| m.max(size[i][j] * rows[i])));
                (0..n).for_each(|i| u[i][j] *= rows[i] * cols[j]);
            }
        }
        let (mut p, mut q): ([usize; BORDERED], [usize; BORDERED]) =
            (std::array::from_fn(|i| i), std::array::from_fn(|j| j));
        let mut lower = [[0.0; BORDERED]; BORDERED];
        for step in 0..n {
            let mut at = (step, step);
            for i in step..n {
                for j in step..n {
                    if u[i][j].abs() > u[at.0][at.1].abs() {
                        at = (i, j);
                    }
                }
            }
            u.swap(step, at.0);
            lower.swap(step, at.0);
            p.swap(step, at.0);
            q.swap(step, at.1);
            u.iter_mut().for_each(|row| row.swap(step, at.1));
            if u[step][step] == 0.0 {
                continue;
            }
            for i in step + 1..n {
                let factor = u[i][step] / u[step][step];
                lower[i][step] = factor;
                for j in step + 1..n {
                    u[i][j] -= factor * u[step][j];
                }
            }
        }
        let last = n - 1;
        let (mut y, mut z) = ([0.0; BORDERED], [0.0; BORDERED]);
        (y[last], z[last]) = (1.0, 1.0);
        for i in (0..last).rev() {
            let sum: f64 = (i + 1..n).map(|j| u[i][j] * y[j]).sum();
            y[i] = if u[i][i] == 0.0 { 0.0 } else { -sum / u[i][i] };
            z[i] = -(i + 1..n).map(|j| lower[j][i] * z[j]).sum::<f64>();
        }
        let (mut right, mut left) = ([0.0; BORDERED], [0.0; BORDERED]);
        for i in 0..n {
            right[q[i]] = cols[q[i]] * y[i];
            left[p[i]] = rows[p[i]] * z[i];
        }
        let nullity = (0..n).filter(|&i| u[i][i].abs() <= SINGULAR * u[0][0].abs()).count();
        Null { right, left, value: u[last][last], nullity }
    }
}

// ---- series

/// A root on the modal series, and how far rounding of the series may have moved it.
#[derive(Debug, Clone, Copy)]
pub struct Refined {
    /// Its place.
    pub x: f64,
    /// Absolute uncertainty, poles being exact.
    pub noise: f64,
    /// How far it moves with the poles: 1 where left and right null vector are one.
    pub condition: f64,
}

/// Eigenvalues that coincide.
#[derive(Debug, Clone)]
pub struct Group {
    modes: Range<usize>,
    /// λ.
    pub lambda: f64,
    /// Roots on it that cancel; none is told of rigid-body modes, at zero.
    pub cancelled: usize,
}

impl Group {
    /// Whether `x` lies among the spread poles.
    pub fn holds(&self, x: f64) -> bool {
        (x - self.lambda).abs() <= 2.0 * IN_GROUP * SPREAD * self.lambda
    }
}

/// H[I, J] as sums over modes, and what stands for those far above.
#[derive(Debug, Clone, Default)]
pub struct MinorSeries {
    order: usize,
    n: usize,
    /// σ, where t = x + σ.
    sigma: Option<f64>,
    /// λ, ascending, then as spread.
    lambda: Vec<f64>,
    spread: Vec<f64>,
    psi: Vec<Each>,
    gamma: Vec<Each>,
    /// d_ik.
    pub constant: [Each; MOST_FORCES],
    /// Up to this the λ are those of modes.
    limit: f64,
    /// The groups of coinciding eigenvalues, rigid-body modes among them.
    pub groups: Vec<Group>,
    /// Whether rounding hides if a root cancels, or more modes coincide than are told apart.
    pub is_open: bool,
    /// t / (λ_n − λ_m) of row m, as spread, and the λ and σ that it was formed of: those of one set of forces.
    gaps: Vec<f64>,
    gaps_of: (Vec<f64>, Option<f64>),
}

impl MinorSeries {
    /// Takes all modes.
    pub fn of_all_modes(&mut self, solver: &SymmetricSolver, ends: &Ends) {
        let (lambda, phi) = (&solver.eigenvalues, &solver.vectors);
        self.begin(ends.order, phi.nrows(), None, f64::INFINITY);
        let at = |dofs: &[usize], r: usize| {
            let mut each = Each::default();
            dofs.iter().enumerate().for_each(|(j, &dof)| each[j] = phi[(dof, r)]);
            each
        };
        for (r, &value) in lambda.iter().enumerate() {
            let value = if value.abs() <= solver.zero { 0.0 } else { value };
            self.add(value, at(ends.responses(), r), at(ends.forces(), r));
        }
        for r in lambda.len()..phi.nrows() {
            let (psi, gamma) = (at(ends.responses(), r), at(ends.forces(), r));
            for i in 0..self.order {
                (0..self.order).for_each(|k| self.constant[i][k] += psi[i] * gamma[k]);
            }
        }
        let rounding = |c: f64, i: usize, k: usize| {
            let largest = |side: &[Each], j: usize| side.iter().fold(0.0_f64, |m, each| m.max(each[j].abs()));
            c.abs() <= ulps(self.n) * f64::EPSILON * largest(&self.psi, i) * largest(&self.gamma, k)
        };
        for i in 0..self.order {
            for k in 0..self.order {
                if rounding(self.constant[i][k], i, k) {
                    self.constant[i][k] = 0.0;
                }
            }
        }
        self.end();
    }

    /// Begins a series between `order` responses and forces of `n` dofs: modes up to `limit`; of a space about −σ.
    pub fn begin(&mut self, order: usize, n: usize, sigma: Option<f64>, limit: f64) {
        (self.order, self.n, self.sigma, self.limit) = (order, n, sigma, limit);
        self.lambda.clear();
        self.psi.clear();
        self.gamma.clear();
        self.constant = Default::default();
    }

    /// Adds a mode, λ ascending.
    pub fn add(&mut self, lambda: f64, psi: Each, gamma: Each) {
        self.lambda.push(lambda);
        self.psi.push(psi);
        self.gamma.push(gamma);
    }

    /// Looks for eigenvalues that coincide, and spreads them.
    pub fn end(&mut self) {
        self.is_open = false;
        self.groups.clear();
        self.spread.clone_from(&self.lambda);
        let n = self.lambda.len();
        let first_elastic = self.lambda.iter().copied().find(|l| *l > 0.0).unwrap_or(1.0);
        let mut from = 0;
        for j in 1..=n {
            let near = |reach: f64| self.lambda[j] - self.lambda[j - 1] <= reach * self.lambda[j].abs();
            if j < n && near(IN_GROUP * SPREAD) {
                self.is_open |= self.lambda[j] <= self.limit && !near(ONE_POLE);
                continue;
            }
            if j - from > 1 {
                let modes = from..j;
                let p = modes.len() as f64;
                let mean = self.lambda[modes.clone()].iter().sum::<f64>() / p;
                for (nth, r) in modes.clone().enumerate() {
                    self.spread[r] = if mean == 0.0 {
                        -SPREAD * first_elastic * (p - 1.0 - nth as f64)
                    } else {
                        mean + mean.abs() * SPREAD * (nth as f64 - 0.5 * (p - 1.0))
                    };
                }
                let cancelled = if mean > 0.0 { self.nullity(&modes, mean) } else { 0 };
                self.groups.push(Group { modes, lambda: mean, cancelled });
            }
            from = j;
        }
    }

    /// Number of null vectors of B at an eigenvalue of several modes.
    fn nullity(&mut self, modes: &Range<usize>, lambda: f64) -> usize {
        if modes.len() + self.order > BORDERED {
            self.is_open |= lambda <= self.limit;
            return 0;
        }
        let here = self.lambda[modes.clone()].to_vec();
        self.lambda[modes.clone()].fill(lambda);
        let (b, _, size) = self.bordered(lambda, modes);
        let found = b.null(Some(&size)).nullity;
        self.lambda[modes.clone()].copy_from_slice(&here);
        found
    }

    /// t at x, and its slope.
    fn factor(&self, x: f64) -> (f64, f64) {
        self.sigma.map_or((1.0, 0.0), |sigma| (x + sigma, 1.0))
    }

    /// H[I, J] without some modes at x, its slope, and the sums of moduli; `lambda` as solved or as spread.
    fn values(&self, x: f64, lambda: &[f64], without: &Range<usize>) -> [Small; 3] {
        let r = self.order;
        let (t, t_slope) = self.factor(x);
        let mut out = [Small::zeros(r); 3];
        let [value, slope, size] = &mut out;
        for m in (0..without.start).chain(without.end..lambda.len()) {
            let s = (lambda[m] - x).recip();
            for i in 0..r {
                for k in 0..r {
                    let part = self.psi[m][i] * self.gamma[m][k] * s;
                    value.a[i][k] += t * part;
                    slope.a[i][k] += (t_slope + t * s) * part;
                    size.a[i][k] += (t * part).abs();
                }
            }
        }
        for i in 0..r {
            for k in 0..r {
                value.a[i][k] += self.constant[i][k];
                size.a[i][k] += self.constant[i][k].abs();
            }
        }
        out
    }

    /// B at x, B', and the moduli that B is made of.
    fn bordered(&self, x: f64, modes: &Range<usize>) -> (Small, Small, Small) {
        let [mut b, mut slope, mut size] = self.values(x, &self.lambda, modes);
        let (t, t_slope) = self.factor(x);
        let r = self.order;
        for small in [&mut b, &mut slope, &mut size] {
            small.n = r + modes.len();
        }
        for (at, m) in (r..).zip(modes.clone()) {
            for j in 0..r {
                (b.a[j][at], b.a[at][j]) = (self.psi[m][j], self.gamma[m][j]);
                (size.a[j][at], size.a[at][j]) = (self.psi[m][j].abs(), self.gamma[m][j].abs());
            }
            let distance = self.lambda[m] - x;
            b.a[at][at] = -distance / t;
            slope.a[at][at] = t.recip() + distance * t_slope / (t * t);
        }
        (b, slope, size)
    }

    /// The modes about `x` that are bordered.
    fn beside(&self, x: f64) -> Range<usize> {
        let (mut from, mut to) = (self.lambda.partition_point(|&l| l < x), 0);
        to = to.max(from);
        while to - from < BORDERED - self.order {
            let below = from.checked_sub(1).map_or(f64::INFINITY, |m| x - self.lambda[m]);
            let above = self.lambda.get(to).map_or(f64::INFINITY, |l| l - x);
            if below.min(above) > BESIDE * x {
                break;
            }
            if below < above { from -= 1 } else { to += 1 }
        }
        from..to
    }

    /// The root nearest to `x`, not farther than spreading may have moved it.
    pub fn refined(&self, x: f64) -> Option<Refined> {
        let modes = self.beside(x);
        let mut at = x;
        for _ in 0..MOST_STEPS {
            let (b, slope, size) = self.bordered(at, &modes);
            let null = b.null(Some(&size));
            let (left, right) = (&null.left[..], &null.right[..]);
            let along = slope.form(left, right);
            let step = -null.value / along;
            at += step;
            // NaN is no root.
            if !((at - x).abs() <= FARTHEST * x) {
                return None;
            }
            let moduli = |v: &[f64]| -> [f64; BORDERED] { std::array::from_fn(|i| v[i].abs()) };
            let error = ulps(self.n) * f64::EPSILON * size.form(&moduli(left), &moduli(right));
            let noise = error / along.abs() + 2.0 * f64::EPSILON * at;
            if step.abs() <= (SETTLED * at).max(noise) {
                let condition = self.sizes(at, &modes, &null) / along.abs();
                return Some(Refined { x: at, noise, condition });
            }
        }
        None
    }

    /// Product of the sizes of left and right null vector in coordinates of the modes.
    fn sizes(&self, x: f64, bordered: &Range<usize>, null: &Null) -> f64 {
        let (r, t) = (self.order, self.factor(x).0);
        let (mut left, mut right) = (0.0, 0.0);
        for (m, (psi, gamma)) in self.psi.iter().zip(&self.gamma).enumerate() {
            let (z, y) = if bordered.contains(&m) {
                let at = r + m - bordered.start;
                (null.left[at] / t, null.right[at])
            } else {
                let along = |each: &Each, v: &[f64]| (0..r).map(|j| each[j] * v[j]).sum::<f64>();
                let s = (self.lambda[m] - x).recip();
                (along(psi, &null.left) * s, along(gamma, &null.right) * s * t)
            };
            left += z * z;
            right += y * y;
        }
        (left * right).sqrt()
    }

    /// Factors of the columns of H at a root, of the modes that are bordered, and which those are: right, left. And
    /// leftᵀ M right of the null vectors that they make; not finite where there are more than one.
    pub fn null_vectors(&self, x: f64) -> (Null, Range<usize>, f64) {
        let modes = self.beside(x);
        let (b, slope, size) = self.bordered(x, &modes);
        let null = b.null(Some(&size));
        let along = if null.nullity > 1 { f64::NAN } else { slope.form(&null.left, &null.right) };
        (null, modes, along)
    }

    /// Forms the factors of the modes in G_m(λ_m), if they are not those of the last minor.
    fn form_gaps(&mut self) {
        if self.gaps_of.0 == self.spread && self.gaps_of.1 == self.sigma {
            return;
        }
        self.gaps.clear();
        for (m, &x) in self.spread.iter().enumerate() {
            let t = self.factor(x).0;
            let row = self.spread.iter().enumerate();
            self.gaps.extend(row.map(|(n, &lambda)| if n == m { 0.0 } else { t / (lambda - x) }));
        }
        self.gaps_of = (self.spread.clone(), self.sigma);
    }

    /// Forms the partial fractions of the minor.
    pub fn form(&mut self, h: &mut Receptance) {
        h.clear();
        let r = self.order;
        let unit = ulps(self.n) * f64::EPSILON;
        // Eigenvalues beyond this stand for those far above.
        let near = self.sigma.map_or(f64::INFINITY, |sigma| 4.0 * (self.limit + sigma));
        let mut sizes = [Each::default(); 2];
        for m in (0..self.lambda.len()).filter(|&m| self.lambda[m] <= near) {
            for (size, each) in sizes.iter_mut().zip([&self.psi[m], &self.gamma[m]]) {
                (0..r).for_each(|j| size[j] = size[j].max(each[j].abs()));
            }
        }
        let q = self.lambda.len();
        let (mut residues, mut errors) = (Vec::with_capacity(q), Vec::with_capacity(q));
        let mut is_zero = true;
        self.form_gaps();
        let pairs: Vec<(usize, usize)> = (0..r).flat_map(|i| (0..r).map(move |k| (i, k))).collect();
        let product = |&(i, k): &(usize, usize)| -> Vec<f64> {
            self.psi.iter().zip(&self.gamma).map(|(psi, gamma)| psi[i] * gamma[k]).collect()
        };
        let products: Vec<Vec<f64>> = pairs.iter().map(product).collect();
        let [mut g, mut size] = [Small::zeros(r); 2];
        for m in 0..q {
            for (&(i, k), product) in pairs.iter().zip(&products) {
                let (value, moduli) = weighted(&self.gaps[m * q..(m + 1) * q], product);
                g.a[i][k] = value + self.constant[i][k];
                size.a[i][k] = moduli + self.constant[i][k].abs();
            }
            let (psi, gamma) = (&self.psi[m], &self.gamma[m]);
            let (residue, moduli) = if r == 2 {
                (g.of_two(psi, gamma, -1.0), size.of_two(&sizes[0], &sizes[1], 1.0))
            } else {
                (-g.bordered(psi, gamma).determinant(), size.bordered(&sizes[0], &sizes[1]).permanent())
            };
            let error = unit * moduli;
            is_zero &= residue.abs() <= error;
            residues.push(residue);
            errors.push(error);
        }
        let known = self.values(0.0, &[], &(0..0));
        let (constant, constant_error) = (known[0].determinant(), unit * known[2].permanent());
        if let Some(sigma) = self.sigma {
            h.begin(sigma, constant);
            h.floor_error += constant_error / sigma;
        } else if constant.abs() > constant_error {
            h.constant = constant;
        }
        h.is_zero = is_zero && constant.abs() <= constant_error;
        let grouped = |m: usize| self.groups.iter().find(|group| group.modes.contains(&m));
        let lone = |m: &usize| grouped(*m).is_none() && self.lambda[*m] <= self.limit;
        let largest = (0..residues.len()).filter(lone).fold(0.0_f64, |l, m| l.max(residues[m].abs()));
        h.negligible = NEGLIGIBLE_RESIDUE * largest;
        let mut open = false;
        for m in 0..residues.len() {
            let (residue, error) = (residues[m], errors[m]);
            let lost = match grouped(m) {
                Some(group) => group.cancelled == group.modes.len(),
                None if self.lambda[m] <= self.limit => {
                    let negligible = residue.abs() <= h.negligible.max(error);
                    open |= residue.abs() <= SURE_RESIDUE * error && SURE_RESIDUE * error > h.negligible;
                    if negligible {
                        h.cancelled.push(self.lambda[m]);
                    }
                    negligible
                }
                None => false,
            };
            if self.lambda[m] > near {
                h.floor_error += 2.0 * error / self.lambda[m];
            } else {
                let by_spread = if self.groups.is_empty() { 0.0 } else { SPREAD * largest };
                h.residue_error = h.residue_error.max(error).max(by_spread);
            }
            if !lost {
                h.poles.push(self.spread[m]);
                h.residues.push(residue);
            }
        }
        self.is_open |= open && !h.is_zero;
    }
}

/// Sum of w p, and of the moduli.
fn weighted(w: &[f64], p: &[f64]) -> (f64, f64) {
    let (mut sums, mut moduli) = ([0.0; LANES], [0.0; LANES]);
    let (w, w_rest) = w.as_chunks::<LANES>();
    let (p, p_rest) = p.as_chunks::<LANES>();
    for (w, p) in w.iter().zip(p) {
        for l in 0..LANES {
            let part = w[l] * p[l];
            sums[l] += part;
            moduli[l] += part.abs();
        }
    }
    let mut both = (total(sums), total(moduli));
    for part in w_rest.iter().zip(p_rest).map(|(w, p)| w * p) {
        both = (both.0 + part, both.1 + part.abs());
    }
    both
}
