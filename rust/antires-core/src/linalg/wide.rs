//! Loops in the widest instructions of the machine, chosen when the program runs.
//!
//! The order of the additions is written out in lanes, and no multiplication is fused with an addition: the
//! bits are the same on every machine.

/// Makes of a function one whose loops run in those instructions; what it calls has to be inlined.
macro_rules! widest {
    ($(#[$attribute:meta])* $visibility:vis fn $name:ident $(<const $length:ident: usize>)?
        ($($argument:ident: $type:ty),+ $(,)?) $(-> $output:ty)? $body:block
    ) => {
        $(#[$attribute])*
        $visibility fn $name $(<const $length: usize>)? ($($argument: $type),+) $(-> $output)? {
            struct Call<A>(A);

            impl $(<const $length: usize>)? pulp::NullaryFnOnce for Call<($($type,)+)> {
                #[allow(unused_parens)] // none is written as ()
                type Output = ($($output)?);

                #[inline(always)]
                fn call(self) -> Self::Output {
                    let Self(($($argument,)+)) = self;
                    $body
                }
            }

            pulp::Arch::new().dispatch(Call(($($argument,)+)))
        }
    };
}
pub(crate) use widest;

/// Sums side by side.
pub const LANES: usize = 4;

/// Sum of the lanes.
#[inline(always)]
#[must_use]
pub fn total(sums: [f64; LANES]) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// a · b; what is left over after whole lanes comes last.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    total(sums) + rest
}

/// x −= c a.
#[inline(always)]
pub fn subtract(x: &mut [f64], c: f64, a: &[f64]) {
    for (x, a) in x.iter_mut().zip(a) {
        *x -= c * a;
    }
}

/// Columns that are read side by side.
pub const COLUMNS: usize = 4;

/// x −= Σ_q c_q a_q, a block of columns in one pass.
#[inline(always)]
pub fn subtract_block(x: &mut [f64], c: [f64; COLUMNS], a: [&[f64]; COLUMNS]) {
    let a = a.map(|a| &a[..x.len()]);
    for (r, x) in x.iter_mut().enumerate() {
        let mut sum = c[0] * a[0][r];
        for q in 1..COLUMNS {
            sum += c[q] * a[q][r];
        }
        *x -= sum;
    }
}

/// a_q · b, a block of columns in one pass.
#[inline(always)]
#[must_use]
pub fn dot_block(a: [&[f64]; COLUMNS], b: &[f64]) -> [f64; COLUMNS] {
    let mut sums = [[0.0; LANES]; COLUMNS];
    let a = a.map(|a| &a[..b.len()]);
    let whole = b.len() / LANES * LANES;
    for at in (0..whole).step_by(LANES) {
        for q in 0..COLUMNS {
            for l in 0..LANES {
                sums[q][l] += a[q][at + l] * b[at + l];
            }
        }
    }
    std::array::from_fn(|q| {
        let rest = a[q][whole..].iter().zip(&b[whole..]);
        total(sums[q]) + rest.map(|(a, b)| a * b).sum::<f64>()
    })
}

/// Largest modulus, NaN where one is not a number.
#[inline(always)]
pub fn largest(a: &[f64]) -> f64 {
    let mut most = [0.0_f64; LANES];
    let mut sum = 0.0;
    let (chunks, rest) = a.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for chunk in chunks {
        for l in 0..LANES {
            let size = chunk[l].abs();
            most[l] = if size > most[l] { size } else { most[l] };
            sums[l] += chunk[l] * 0.0;
        }
    }
    for value in rest {
        most[0] = most[0].max(value.abs());
        sum += value * 0.0;
    }
    most.into_iter().fold(0.0, f64::max) + (sum + total(sums))
}
