//! Variations of Riemannian cubics: exact directional derivatives with respect to initial data, by dual numbers.
//!
//! The frame rotates by `g^{-1} dg`, whose part in `m` is the displacement `p` of the point. The rotation of the whole
//! space that displaces the point by `p` carries `x, x', x''` along; `w, a, b` are their changes relative to that
//! rotation,
//!
//! ```math
//! p = (g^{-1}\,\delta g)_m,\qquad w = \delta x + [(g^{-1}\,\delta g)_h, x],\qquad a, b\ \text{alike from}\ x', x''
//! ```

use faer::Mat;

use crate::cubic::taylor::blocks::{BlockSizes, Sizes};
use crate::cubic::taylor::initial::{Horizontal, InitialData};
use crate::cubic::taylor::march::{Accuracy, TaylorMarch};
use crate::cubic::taylor::packing::pack;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::dual::{Dual, Number};
use crate::space::Quotient;

/// Variations of a curve at one time, in coordinates in which the frame at the start is the identity.
pub(crate) struct Reached {
    quotient: Quotient,
    /// The frame at that time, shape `(r, r)`.
    pub(crate) frame: Mat<f64>,
    /// `x, x', x''` at that time.
    state: [Horizontal; 3],
    /// `(p, w, a, b)` in the frame, one set per direction.
    pub(crate) variations: Vec<[Horizontal; 4]>,
}

/// The variations, at several times after the start, of the curve with the given initial data; the start point is
/// fixed. A pass carries `N` directions.
///
/// # Arguments
/// * `extra` - number of additional rows outside the span, in which the curve is zero
/// * `directions` - variations of `(x, x', x'')`; the normal parts have `extra` more rows than those of the data
/// # Errors
/// `TooManySteps`, `Overflow`, `Interrupted`.
pub(crate) fn vary<const N: usize>(
    data: &InitialData,
    extra: usize,
    directions: &[[Horizontal; 3]],
    times: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<Vec<Reached>> {
    let k = data.velocity.omega.nrows();
    let blocks = Sizes::new(data.velocity.normal.nrows() + extra, k, data.quotient);
    let mut out: Vec<Reached> = Vec::new();
    out.resize_with(times.len(), || Reached::none(blocks));
    let mut march = TaylorMarch::<Dual<N>, Sizes>::new(blocks, Accuracy::FULL);
    // A curve without degrees of freedom still has a frame.
    let passes = directions
        .chunks(N)
        .chain(directions.is_empty().then_some(&[][..]));
    for pass in passes {
        start(&mut march, data, pass);
        for (reached, &t) in out.iter_mut().zip(times) {
            let behind = t.abs() < march.time.abs() || t * march.time < 0.0;
            if behind {
                start(&mut march, data, pass);
            }
            march.run(t, interrupt, &mut |_, _, _| Ok(()))?;
            reached.read(&march, pass.len());
        }
    }
    Ok(out)
}

impl Reached {
    /// An empty set of variations.
    pub(crate) fn none(blocks: Sizes) -> Self {
        let r = blocks.m + blocks.k;
        Reached {
            quotient: blocks.quotient,
            frame: Mat::zeros(r, r),
            state: std::array::from_fn(|_| Horizontal::zeros(blocks)),
            variations: Vec::new(),
        }
    }

    /// Appends the variations of the state that a march has reached.
    pub(crate) fn read<const N: usize>(
        &mut self,
        march: &TaylorMarch<Dual<N>, Sizes>,
        count: usize,
    ) {
        let Sizes { m, k, .. } = march.blocks;
        let (r, series) = (m + k, &march.series);
        let frame = |i: usize, j: usize| match j.checked_sub(k) {
            None => &series.s()[i + r * j],
            Some(j) => &series.e()[i + r * j],
        };
        let vectors = |pick: &dyn Fn(&Dual<N>) -> f64| {
            std::array::from_fn(|level| Horizontal {
                omega: match march.blocks.are_subspaces() {
                    true => Mat::zeros(k, k),
                    false => Mat::from_fn(k, k, |i, j| pick(&series.omega(level)[i + k * j])),
                },
                normal: Mat::from_fn(m, k, |i, j| pick(&series.b(level)[i + m * j])),
            })
        };
        self.frame = Mat::from_fn(r, r, |i, j| frame(i, j).value);
        self.state = vectors(&|x| x.value);
        for direction in 0..count {
            let slope = Mat::from_fn(r, r, |i, j| frame(i, j).slope[direction]);
            let turn = self.frame.transpose() * slope;
            let varied = self.split(&turn, vectors(&|x| x.slope[direction]));
            self.variations.push(varied);
        }
    }

    /// The variation that displaces the start by `u` and rotates the whole curve with it.
    pub(crate) fn displaced(&self, u: &Horizontal) -> [Horizontal; 4] {
        let (m, k) = u.normal.shape();
        let turn = self.frame.transpose() * (u.matrix() * &self.frame);
        let still = std::array::from_fn(|_| Horizontal::zeros(Sizes::frames(m, k)));
        self.split(&turn, still)
    }

    /// `(p, w, a, b)` from the rotation of the frame and the derivatives of `x, x', x''`.
    fn split(&self, turn: &Mat<f64>, slopes: [Horizontal; 3]) -> [Horizontal; 4] {
        let (m, k) = slopes[0].normal.shape();
        let is_subspace = self.quotient == Quotient::Subspaces;
        let p = Horizontal {
            omega: match is_subspace {
                true => Mat::zeros(k, k),
                false => Mat::from_fn(k, k, |i, j| 0.5 * (turn[(i, j)] - turn[(j, i)])),
            },
            normal: turn.submatrix(k, 0, m, k).to_owned(),
        };
        let [mut w, mut a, mut b] = slopes;
        for (slope, x) in [&mut w, &mut a, &mut b].into_iter().zip(&self.state) {
            slope.normal += turn.submatrix(k, k, m, m) * &x.normal;
            if is_subspace {
                slope.normal -= &x.normal * turn.submatrix(0, 0, k, k);
            }
        }
        [p, w, a, b]
    }
}

/// Places a march at the start of a curve, with the identity as its frame and derivatives with their variations.
pub(crate) fn start<const N: usize>(
    march: &mut TaylorMarch<Dual<N>, Sizes>,
    data: &InitialData,
    directions: &[[Horizontal; 3]],
) {
    let Sizes { m, k, .. } = march.blocks;
    let longer = |x: &Horizontal| {
        let mut longer = x.clone();
        longer.normal.resize_with(m, k, |_, _| 0.0);
        longer
    };
    let values = pack(
        march.blocks,
        &[&data.velocity, &data.acceleration, &data.second()].map(longer),
    );
    let mut entries: Vec<Dual<N>> = values.into_iter().map(Dual::constant).collect();
    for (i, direction) in directions.iter().enumerate() {
        for (entry, slope) in entries.iter_mut().zip(pack(march.blocks, direction)) {
            entry.slope[i] = slope;
        }
    }
    march.series.set_tension(data.tension);
    march.longest = longest(data.tension, march.accuracy);
    march.place(entries);
}

/// The step in which the last term of `cosh(sqrt(tau) t)` falls below the truncation: variations grow like that in tension,
/// even along a curve at rest, whose own terms all vanish.
fn longest(tension: f64, accuracy: Accuracy) -> f64 {
    let factorial: f64 = (1..=accuracy.order).map(|i| i as f64).product();
    let reach = (accuracy.truncation * factorial).powf(1.0 / accuracy.order as f64);
    reach / tension.sqrt()
}
