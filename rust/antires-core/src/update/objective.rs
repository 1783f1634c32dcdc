//! The antiresonance objective J(x).
//!
//! # linearization
//!
//! What the optimizer asks of the antiresonance objective: its cost and the first derivatives of its residuals.
//!
//! ```text
//! e = x_A / x_E − 1,  x = ω²        de/dp = (dx_A/dp) / x_E
//! ```
//!
//! with dx_A/dp from [`ZeroSensitivity`], and at the edge of the band as of [`crate::update::pairing`].
//! The pairing counts as fixed: where a measured antiresonance is about to change its partner the linear model is
//! wrong, and the optimizer's trust region finds out.
//!
//! # state
//!
//! All roots that a measurement could show of the model at one x, and how they move.
//!
//! ```text
//! d ln f / dp = (dx/dp) / (2 x),  x = ω²
//! ```
//!
//! An objective asks for the partners of what was measured. Who compares two states of a structure (intact and
//! damaged) must follow the roots themselves, measured or not, from one state to the other.
//!
//! # null_vectors
//!
//! The roots of all targets at one x with their null vectors, for who joins these with changes of the model himself.
//!
//! ```text
//! dx/dp = leftᵀ (dK/dp − x dM/dp) right / slope,  x = ω²
//! ```
//!
//! On a reduced model dK/dp of a few elements is dense; of the full one it is not, and the null vectors of the
//! reduced model are those of the full one in few coordinates.
//!
//! # sight
//!
//! What a measurement can show of the model's roots.
//!
//! Where a mode has a node at sensor i, the root of det(K_ik − x M_ik) on its pole cancels in H_ik: the FRF shows
//! nothing. But H_jk of another sensor has the pole, so T_ji = H_jk / H_ik has a peak there. Transmissibilities lose
//! only those roots that all measured responses have: of a mode on whose node the force sits, or of a part of the
//! structure that lies on the other side of the force.
//!
//! | source | roots of response i that it shows |
//! |---|---|
//! | FRFs | the zeros of H_ik |
//! | transmissibilities | all of the deleted pencil, less those that every response measured with it has |
//! | not known | all may be partners of what was measured |
//!
//! A model that is nearly symmetric has them all, hardly apart. So that J does not jump where a symmetry breaks, a
//! root that all responses share comes in by degrees, as they part.

use std::ops::RangeInclusive;
use std::sync::Arc;

use super::pairing::{Pairing, UNPAIRED};
use super::unknowns::{Misfit, Penalty, Unknowns, checked_weights};
use crate::antiresonances::{
    AntiresonanceSolver, Prepared, Query, Route, Transfer, ZeroBatch, ZeroSensitivity,
};
use crate::error::{Error, Result};
use crate::fem::assembly::{Assembly, MatrixSlopes};
use crate::fem::model::{Model, joins};
use crate::fem::parameters::Parameter;
use crate::modal::minor::Ends;
use crate::modal::modes::eigenvalue;
use crate::modal::structure::Structure;
use crate::optimize::{Composition, Linearization, Objective};

/// The model's antiresonances are computed to this multiple of the highest measured frequency, so
/// that the edge of the band cuts off no partner.
pub const BAND_MARGIN: f64 = 1.5;

/// Measured antiresonances of one response to one force, or of r responses to r forces.
#[derive(Debug, Clone, Default)]
pub struct Target {
    /// Dofs of response and force, or of all of them.
    pub ends: Ends,
    /// Antiresonant frequencies (Hz); none where the response only was measured with others.
    pub freq_hz: Vec<f64>,
    /// What they were identified from.
    pub sees: Sees,
    /// Targets of one number were measured together: transmissibilities lose what all of these share.
    pub together: usize,
}

/// J(x) for one model, one parameter set and one measurement.
pub struct AntiresonanceObjective {
    /// The model and what may change in it.
    pub unknowns: Unknowns,
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
struct Roots {
    /// Those that may be partners (Hz), ascending.
    hz: Vec<f64>,
    /// Those among them that lie on a pole and cancel.
    cancelled_hz: Vec<f64>,
    /// Whether the response is there at all.
    present: bool,
}

/// The model at one x, ready to be solved.
struct Formed<'a> {
    prepared: Prepared<'a>,
    /// Target by target, once [`AntiresonanceObjective::pairs_of`] has found them.
    roots: &'a mut Vec<Roots>,
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
            target.ends.responses().iter().try_for_each(|&dof| model.check_dof("measured", dof))?;
            target.ends.forces().iter().try_for_each(|&dof| model.check_dof("excitation", dof))?;
            if let Some(f) = target.freq_hz.iter().find(|f| !(f.is_finite() && **f > 0.0)) {
                return Err(Error::input(
                    "measured",
                    format!("{f} Hz at {}", named(target.ends.responses())),
                    "positive, finite frequencies",
                )
                .remedy("Drop it from the measured set: an antiresonance at 0 Hz is a rigid motion."));
            }
        }
        let highest = targets.iter().flat_map(|t| &t.freq_hz).fold(0.0_f64, |m, &f| m.max(f));
        if highest == 0.0 {
            return Err(Error::input("measured", "no antiresonance", "at least one")
                .remedy("Identify in a wider band, or measure at more dofs."));
        }
        let unknowns = Unknowns::new(model, parameters, penalty, snap)?;
        let model = &unknowns.model;
        let (k_mat, m_mat) = (model.stiffness(), model.mass());
        let connected =
            targets.iter().map(|t| joins(k_mat, m_mat, t.ends.responses(), t.ends.forces())).collect();
        let weights = vec![1.0; targets.iter().map(|t| t.freq_hz.len()).sum()];
        let others = (0..targets.len()).map(|nth| measured_with(&targets, nth)).collect();
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

    /// The same objective with residual m multiplied by `weights[m]`, in the order of the targets; by one
    /// without any.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] when there is not one finite, not negative weight for each measured value,
    /// or all are zero.
    pub fn with_weights(mut self, weights: Option<Vec<f64>>) -> Result<Self> {
        if let Some(weights) = weights {
            self.weights = checked_weights(weights, self.weights.len())?;
        }
        Ok(self)
    }

    /// The analytic partner of each measured antiresonance and its residual, target by target.
    pub fn pairs(&self, x: &[f64], ws: &mut Workspace) -> Result<Vec<Pairing>> {
        self.pairs_of(&mut self.form(x, ws))
    }

    /// J at `x`, of which these are the pairs.
    pub fn cost_of(&self, x: &[f64], pairs: &[Pairing]) -> f64 {
        self.total(pairs.iter().map(|pairing| pairing.residual), &self.unknowns.snapped(x))
    }

    /// J of residuals at parameter values that are already snapped.
    fn total(&self, residuals: impl Iterator<Item = f64>, snapped: &[f64]) -> f64 {
        let weighted = residuals.zip(&self.weights).map(|(e, weight)| weight * e);
        weighted.fold(0.0, |total, e| self.misfit.add(total, e)) + self.unknowns.penalty_at(snapped)
    }

    /// K(x) and M(x).
    fn form<'a>(&self, x: &[f64], ws: &'a mut Workspace) -> Formed<'a> {
        let Workspace { assembly, solver, roots } = ws;
        assembly.form(&self.unknowns.model, &self.unknowns.parameters, x);
        Formed { prepared: solver.prepare(&assembly.stiffness, &assembly.mass), roots }
    }

    /// [`pairs`](Self::pairs) of a model that is formed.
    fn pairs_of(&self, formed: &mut Formed<'_>) -> Result<Vec<Pairing>> {
        let mut pairs = Vec::with_capacity(self.weights.len());
        self.each_pair(formed, |pairing| pairs.push(pairing))?;
        Ok(pairs)
    }

    fn each_pair(&self, formed: &mut Formed<'_>, mut visit: impl FnMut(Pairing)) -> Result<()> {
        self.find_roots(formed)?;
        for (nth, target) in self.targets.iter().enumerate() {
            let own = &formed.roots[nth].hz;
            let shown = |root| shown(own, root, self.others_of(nth, formed.roots));
            target.freq_hz.iter().for_each(|&hz| visit(Pairing::of(own, shown, hz, self.limit_hz)));
        }
        Ok(())
    }

    /// The roots of those measured with target `nth`, where it matters what all of them share.
    fn others_of<'a>(&'a self, nth: usize, roots: &'a [Roots]) -> impl Iterator<Item = &'a [f64]> {
        let there = self.others[nth].iter().filter(|&&o| roots[o].present);
        there.map(|&o| roots[o].hz.as_slice())
    }

    /// Takes up the root of a target at `hz`.
    fn set(&self, zero: &mut ZeroSensitivity, formed: &mut Formed<'_>, target: usize, hz: f64) -> Result<()> {
        let (ends, x) = (&self.targets[target].ends, eigenvalue(hz));
        if formed.roots[target].cancelled_hz.contains(&hz) {
            zero.set_cancelled(&mut formed.prepared, ends, x)
        } else {
            zero.set(&mut formed.prepared, ends, x)
        }
    }

    /// The roots of each target; of one without values only if others are compared with it.
    fn find_roots(&self, formed: &mut Formed<'_>) -> Result<()> {
        for (nth, target) in self.targets.iter().enumerate() {
            let Roots { hz, cancelled_hz, present } = &mut formed.roots[nth];
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
            let found = formed.prepared.find(&target.ends, &query, hz)?;
            *present = found == Transfer::Present;
            if query.include_cancelled && *present {
                formed.prepared.cancelled(cancelled_hz);
            }
        }
        Ok(())
    }
}

/// Dofs in words.
fn named(dofs: &[usize]) -> String {
    match dofs {
        [dof] => format!("dof {dof}"),
        _ => format!("dofs {dofs:?}"),
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

// ---- linearization

impl Objective for AntiresonanceObjective {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        Workspace {
            assembly: Assembly::new(&self.unknowns.model),
            solver: AntiresonanceSolver::new(&self.structure),
            roots: vec![Roots::default(); self.targets.len()],
        }
    }

    /// J(x). Where the eigenproblem fails, every measured value counts as unpaired, so that J stays
    /// finite for every x in bounds.
    fn cost(&self, x: &[f64], ws: &mut Workspace) -> f64 {
        let (snapped, n) = (self.unknowns.snapped(x), self.weights.len());
        let mut residuals = Vec::with_capacity(n);
        let solved = self.each_pair(&mut self.form(&snapped, ws), |pairing| residuals.push(pairing.residual));
        if solved.is_err() {
            residuals = vec![UNPAIRED; n];
        }
        self.total(residuals.into_iter(), &snapped)
    }

    fn composition(&self) -> Option<Composition> {
        Some(self.unknowns.composition(self.misfit.norm()))
    }

    /// J, its residuals and their derivatives; `None` where the eigenproblem fails.
    fn linearize(&self, x: &[f64], ws: &mut Workspace) -> Option<Linearization> {
        let snapped = self.unknowns.snapped(x);
        let mut formed = self.form(&snapped, ws);
        let pairs = self.pairs_of(&mut formed).ok()?;
        let slopes = self.unknowns.slopes(&snapped);
        let residuals: Vec<f64> = pairs.iter().zip(&self.weights).map(|(p, w)| w * p.residual).collect();
        let mut found = Linearization {
            cost: self.total(pairs.iter().map(|pairing| pairing.residual), &snapped),
            jacobian: vec![0.0; residuals.len() * slopes.len()],
            residuals,
        };
        let (mut zero, mut batch) = (ZeroSensitivity::default(), ZeroBatch::default());
        let targets = self.targets.iter().enumerate();
        let measured = targets.flat_map(|(nth, target)| target.freq_hz.iter().map(move |&hz| (nth, hz)));
        for (m, ((target, hz), pairing)) in measured.zip(pairs).enumerate() {
            for (analytic_hz, along) in pairing.moves_with.into_iter().flatten() {
                self.set(&mut zero, &mut formed, target, analytic_hz).ok()?;
                let (weight, measured) = (self.weights[m], eigenvalue(hz));
                batch.push(&zero, Row { first: m * slopes.len(), along, weight, measured });
                if batch.is_full() {
                    add(&mut batch, &slopes, &mut found.jacobian);
                }
            }
        }
        add(&mut batch, &slopes, &mut found.jacobian);
        Some(found)
    }

    /// Negligible severities become exactly zero.
    fn repair(&self, x: &mut [f64]) {
        self.unknowns.snap(x);
    }
}

/// The row of the Jacobian that a root moves, and how.
struct Row {
    first: usize,
    along: f64,
    weight: f64,
    measured: f64,
}

/// Adds what the roots in the batch have to say, and empties it.
fn add(batch: &mut ZeroBatch<Row>, slopes: &[MatrixSlopes], jacobian: &mut [f64]) {
    for (p, slopes) in slopes.iter().enumerate() {
        batch.along(slopes, |row, dx| {
            let slope = row.weight * dx / row.measured;
            // A double zero has no derivative; the descent must not follow one.
            jacobian[row.first + p] += if slope.is_finite() { row.along * slope } else { 0.0 };
        });
    }
    batch.clear();
}

// ---- state

/// Frequencies (Hz) between two limits.
pub type Band = RangeInclusive<f64>;

/// The roots of all targets at one x, target by target, ascending in each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Number of the target.
    pub target: Vec<u32>,
    /// Frequencies (Hz).
    pub freq_hz: Vec<f64>,
    /// How much the measurement shows of each, 0 to 1; see [`sight`](crate::update::objective).
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
        let slopes = slopes_hz.map_or_else(Vec::new, |_| self.unknowns.slopes(x));
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
    fn each_root(
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
                    self.set(&mut zero, &mut formed, nth, hz)?;
                }
                let zero = inside.then_some(&zero);
                visit(Root { target: nth, hz, shown, zero });
            }
        }
        Ok(())
    }
}

/// A root of a target, with its null vectors where those were asked for.
struct Root<'a> {
    target: usize,
    hz: f64,
    shown: f64,
    zero: Option<&'a ZeroSensitivity>,
}

impl Root<'_> {
    /// Adds it to a state, without slopes.
    fn put_into(&self, state: &mut State) {
        state.target.push(u32::try_from(self.target).unwrap_or(u32::MAX));
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

// ---- null_vectors

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
        let n = self.unknowns.model.n_dof();
        let mut found = NullVectors::default();
        let all = self.each_root(x, ws, Some(band), |root| {
            root.put_into(&mut found.state);
            let filled = found.left.len();
            if let Some(zero) = root.zero {
                found.left.extend_from_slice(&zero.left);
                found.right.extend_from_slice(&zero.right);
                found.slope.push(zero.slope);
            } else {
                found.slope.push(f64::NAN);
            }
            found.left.resize(filled + n, 0.0);
            found.right.resize(filled + n, 0.0);
        });
        all.map_or_else(|_| NullVectors::default(), |()| found)
    }
}

// ---- sight

/// What a set of antiresonances was identified from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sees {
    /// Frequency response functions.
    Frf,
    /// Quotients of responses.
    Transmissibility,
    /// Not known.
    #[default]
    Unknown,
}

/// Relative distance in Hz up to which roots of two responses are one, and from which on both are seen in full.
/// Identification reports none that come so near in all responses.
const ONE: f64 = 1e-6;
const APART: f64 = 1e-3;

/// How much transmissibilities show of `own[nth]`, a root of one response: 0 if all `others` share it, 1 if one of
/// them does not. All lists ascending, in Hz.
pub fn shown<'a>(own: &[f64], nth: usize, others: impl Iterator<Item = &'a [f64]>) -> f64 {
    let mut largest: Option<f64> = None;
    for other in others {
        let share = ((apart(own, nth, other) - ONE) / (APART - ONE)).clamp(0.0, 1.0);
        if share >= 1.0 {
            return 1.0;
        }
        largest = Some(largest.map_or(share, |most| most.max(share)));
    }
    // Alone, there is nothing to share with.
    largest.unwrap_or(1.0)
}

/// Relative distance of `own[nth]` from its counterpart in `other`, each root having one counterpart at most;
/// infinity without any in reach.
fn apart(own: &[f64], nth: usize, other: &[f64]) -> f64 {
    let x = own[nth];
    let near = |list: &[f64], reach: f64| {
        let first = list.partition_point(|&f| f < x - reach);
        first..list.partition_point(|&f| f <= x + reach)
    };
    let theirs = near(other, APART * x);
    if theirs.is_empty() {
        return f64::INFINITY;
    }
    // Others of this response may claim the same counterpart. The nearest pairs go first.
    let mut pairs: Vec<(f64, usize, usize)> = near(own, 2.0 * APART * x)
        .flat_map(|a| near(other, 3.0 * APART * x).map(move |b| ((own[a] - other[b]).abs(), a, b)))
        .collect();
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (distance, a, b) in pairs {
        if taken.iter().any(|&(c, d)| c == a || d == b) {
            continue;
        }
        if a == nth {
            return distance / x;
        }
        taken.push((a, b));
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::model::mass_spring_chain;
    use crate::fem::parameters::Quantity;
    use crate::optimize::{Candidates, evaluate_many};

    const X: [f64; 3] = [0.2, 1.1, 0.9];

    fn objective() -> AntiresonanceObjective {
        let model = mass_spring_chain(&[0.5, 0.4, 0.6, 0.3], &[5e4, 7e4, 4e4], 2e4, 0.0).unwrap();
        let quantities = [Quantity::StiffnessReduction, Quantity::StiffnessFactor, Quantity::MassFactor];
        let parameter = |quantity| Parameter { quantity, terms: vec![1] };
        let target = |dof| Target { ends: (dof, 0).into(), freq_hz: vec![40.0, 90.0], ..Target::default() };
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
        let state = |o: &AntiresonanceObjective, x: &[f64], ws: &mut Workspace| o.state(x, ws, Some(&band));
        let found = evaluate_many(&objective(), Candidates::new(rows, 3), threads, state, &mut || None);
        found.unwrap().continue_value().unwrap()
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
                let difference = (both[1].freq_hz[root] - both[0].freq_hz[root]) / (2.0 * STEP * hz);
                let slope = here.slopes[3 * root + p];
                assert!((slope - difference).abs() < 1e-8, "{slope} {difference}");
            }
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let rows: Vec<f64> = (0..20).flat_map(|i| [0.04 * f64::from(i), 1.0, 1.0]).collect();
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

    #[test]
    fn null_vectors_joined_with_a_term_are_the_slopes() {
        let model = mass_spring_chain(&[0.5, 0.4, 0.6, 0.3], &[5e4, 7e4, 4e4], 2e4, 0.0).unwrap();
        let spring = Parameter { quantity: Quantity::StiffnessFactor, terms: vec![1] };
        let targets = [0, 2].map(|dof| Target {
            ends: (dof, 0).into(),
            freq_hz: vec![40.0, 90.0],
            ..Target::default()
        });
        let objective =
            AntiresonanceObjective::new(model, vec![spring], targets.to_vec(), Misfit::Absolute, None, 0.0)
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

    fn of(own: &[f64], nth: usize, others: &[&[f64]]) -> f64 {
        shown(own, nth, others.iter().copied())
    }

    #[test]
    fn only_what_all_share_is_lost() {
        let own = [10.0, 20.0, 30.0];
        assert_eq!(of(&own, 1, &[&[20.0], &[15.0, 20.0]]), 0.0);
        assert_eq!(of(&own, 1, &[&[20.0], &[15.0]]), 1.0);
        assert_eq!(of(&own, 1, &[&[20.0], &[]]), 1.0);
        assert_eq!(of(&own, 1, &[]), 1.0);
    }

    #[test]
    fn one_of_two_on_a_pole_is_lost_to_one_of_the_others() {
        let own = [20.0, 20.0];
        let shares = [0, 1].map(|nth| of(&own, nth, &[&[20.0], &[20.0]]));
        assert_eq!(shares, [0.0, 1.0]);
        // However far the second has moved.
        for step in [1e-9, 1e-5, 1e-3, 1e-2] {
            let own = [20.0, 20.0 * (1.0 + step)];
            assert_eq!(of(&own, 1, &[&[20.0], &[20.0]]), 1.0, "{step}");
            assert_eq!(of(&own, 0, &[&[20.0], &[20.0]]), 0.0, "{step}");
        }
    }

    #[test]
    fn it_comes_in_by_degrees() {
        let at = |gap: f64| of(&[20.0], 0, &[&[20.0], &[20.0 * (1.0 + gap)]]);
        let steps: Vec<f64> = (0..2_000).map(|i| at(1e-6 * f64::from(i))).collect();
        let steepest = steps.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!(steepest < 1.1e-3, "{steepest}");
        assert_eq!((steps[0], steps[1_999]), (0.0, 1.0));
    }
}
