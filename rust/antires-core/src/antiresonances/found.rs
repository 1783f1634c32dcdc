//! What is known of the roots of one response while they are searched for.

use super::newton::Placed;

/// Relative distance in x within which two roots, placed on the matrices from different starts, are one.
const ONE_ROOT: f64 = 1e-8;

/// Relative distance in x within which two roots of one series were placed on the same one.
const FOUND_TWICE: f64 = 1e-12;

/// Ulps of K and M within which two roots placed on the matrices are one.
const SAME_ULPS: f64 = 16.0;

/// Whether a root that cancels against a pole is there for sure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Presence {
    Sure,
    /// Rounding hides it; the pencil has to tell.
    Open,
}

/// The roots of one response, in x = ω².
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    /// Isolated by a change of sign, and placed.
    proven: Vec<f64>,
    /// Those that rounding may have made.
    open: Vec<f64>,
    /// Poles on which a root lies that cancels.
    cancelled: Vec<(f64, Presence)>,
    /// Roots below this are zero at working precision.
    floor: f64,
}

/// How many roots there were at some time.
#[derive(Clone, Copy)]
pub(super) struct Mark {
    proven: usize,
    cancelled: usize,
}

impl Found {
    /// Forgets all roots; those below `floor` are zero from now on.
    pub fn begin(&mut self, floor: f64) {
        self.proven.clear();
        self.open.clear();
        self.cancelled.clear();
        self.floor = floor;
    }

    pub fn floor(&self) -> f64 {
        self.floor
    }

    pub fn prove(&mut self, x: f64) {
        self.proven.push(x);
    }

    pub fn leave_open(&mut self, x: f64) {
        self.open.push(x);
    }

    pub fn cancel(&mut self, x: f64, presence: Presence) {
        self.cancelled.push((x, presence));
    }

    pub fn mark(&self) -> Mark {
        Mark {
            proven: self.proven.len(),
            cancelled: self.cancelled.len(),
        }
    }

    /// Sorts the roots proven since.
    pub fn sort_since(&mut self, mark: Mark) {
        self.proven[mark.proven..].sort_by(f64::total_cmp);
    }

    /// Drops what was found since, above `limit` but for an overlap, and was known before.
    pub fn drop_twice(&mut self, since: Mark, limit: f64) {
        let (lower, upper) = self.proven.split_at(since.proven);
        let again = |x: &f64| {
            let twice = |y: &f64| (x - y).abs() <= ONE_ROOT * y;
            *x <= limit * (1.0 + ONE_ROOT) && lower.iter().any(twice)
        };
        let upper: Vec<f64> = upper.iter().copied().filter(|x| !again(x)).collect();
        self.proven.truncate(since.proven);
        self.proven.extend(upper);
        let mut index = 0;
        self.cancelled.retain(|&(x, _)| {
            index += 1;
            index <= since.cancelled || x > limit
        });
    }

    /// Drops the cancelled roots that are zero at working precision.
    pub fn drop_cancelled_zeros(&mut self) {
        let floor = self.floor;
        self.cancelled.retain(|&(x, _)| x > floor);
    }

    /// Lets each proven or cancelled root take its own from elsewhere. A cancelled one then lies there; one
    /// that was open and finds none is dropped.
    pub fn claim(&mut self, mut take_nearest: impl FnMut(f64) -> Option<f64>) {
        for &x in &self.proven {
            take_nearest(x);
        }
        self.cancelled.retain_mut(|(x, presence)| {
            let own = take_nearest(*x);
            *x = own.unwrap_or(*x);
            *presence == Presence::Sure || own.is_some()
        });
    }

    /// Whether a root placed on the matrices is one of those proven or cancelled.
    pub fn has(&self, Placed { x, ulp }: Placed) -> bool {
        let known = |y: &f64| (x - y).abs() <= (ONE_ROOT * y).max(SAME_ULPS * ulp);
        self.proven.iter().any(known) || self.cancelled().any(|y| known(&y))
    }

    /// Takes the open roots for proven ones.
    pub fn settle_open(&mut self) {
        self.proven.append(&mut self.open);
    }

    /// Takes the cancelled roots for proven ones.
    pub fn include_cancelled(&mut self) {
        self.proven.extend(self.cancelled.iter().map(|&(x, _)| x));
    }

    /// Where roots lie that cancel.
    pub fn cancelled(&self) -> impl Iterator<Item = f64> {
        self.cancelled.iter().map(|&(x, _)| x)
    }

    /// The proven roots, ascending.
    pub fn sorted(&mut self) -> &[f64] {
        self.proven.sort_by(f64::total_cmp);
        &self.proven
    }
}

/// Whether two roots of one series, isolated apart, were placed on the same root.
pub(super) fn placed_twice(here: Placed, before: f64) -> bool {
    (here.x - before).abs() <= (FOUND_TWICE * here.x).max(SAME_ULPS * here.ulp)
}
