//! The start of a cubic that is linearised: a frame whose columns span the curve, and the vectors of the equation.

use super::linear_flow::LinearFlow;
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::taylor::packing::{pack, pack_blocks};
use crate::cubic::taylor::state::State;
use crate::curve::Curve;
use crate::error::Result;
use crate::linalg::product::{columns, columns_mut, entries, mul_into};

/// The start of a curve.
#[derive(Debug, Clone)]
pub(crate) struct LinearStart {
    /// The blocks of the span of the curve.
    pub(crate) blocks: Sizes,
    /// The frame, shape `(n, r)` by columns, whose columns span the curve.
    pub(crate) frame: Vec<f64>,
    /// Coordinates of `x, x', x''`.
    pub(crate) vectors: [Vec<f64>; 3],
    pub(crate) tension: f64,
    /// Rows of a point.
    pub(crate) n: usize,
}

/// The state of a curve at time 0, if its polynomials begin there and its frame is no larger than the span of a point
/// and three vectors, with vectors in it.
pub(crate) fn spanning(curve: &RiemannianCubic) -> Option<&State> {
    curve.state_of_taylor(0.0).filter(|state| {
        let Sizes { m, k, .. } = state.blocks;
        m <= 3 * k && (m > 0 || m + k == curve.n())
    })
}

impl LinearStart {
    pub(crate) fn of_flow(flow: &LinearFlow) -> Self {
        let (data, blocks) = (&flow.data, flow.blocks());
        let packed = |x: &Horizontal| pack(blocks, std::slice::from_ref(x));
        LinearStart {
            blocks,
            frame: entries(flow.frame.as_ref()),
            vectors: [
                packed(&data.velocity),
                packed(&data.acceleration),
                packed(&data.second()),
            ],
            tension: data.tension,
            n: flow.frame.nrows(),
        }
    }

    /// The start of a curve on `[0, 1]`.
    ///
    /// # Errors
    /// The errors of evaluating the curve, if its polynomials do not begin there or have too large a span.
    pub(crate) fn of_curve(curve: &RiemannianCubic) -> Result<Self> {
        let found = spanning(curve);
        let Some(state) = found else {
            let data = curve.state(0.0)?;
            let views = data.each_ref().map(|x| x.as_ref());
            let flow = LinearFlow::new(views, curve.tension(), curve.quotient())?;
            return Ok(Self::of_flow(&flow));
        };
        let Sizes { m, k, quotient, .. } = state.blocks;
        let (blocks, n) = (Sizes::new(m, k, quotient), curve.n());
        let r = blocks.m + blocks.k;
        let low = &state.entries[..r * r];
        let frame = match curve.frame() {
            None => low.to_vec(),
            Some(basis) => {
                let mut frame = vec![0.0; n * r];
                mul_into(columns_mut(&mut frame, n), 1.0, basis, columns(low, r));
                frame
            }
        };
        let vectors = state.entries[r * r..].chunks_exact(r * blocks.k);
        let mut vectors = vectors.zip(1..).map(|(x, order)| {
            let mut out = vec![0.0; blocks.dim()];
            pack_blocks(blocks, x, &mut out);
            for x in &mut out {
                *x = curve.time_map.derivative(*x, order);
            }
            out
        });
        Ok(LinearStart {
            blocks,
            frame,
            vectors: std::array::from_fn(|_| vectors.next().unwrap_or_default()),
            tension: curve.tension(),
            n,
        })
    }

    /// A bound on the velocity up to second order, about the middle of the curve, or on the rate of growth in tension.
    pub(crate) fn speed(&self) -> f64 {
        let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let middle = |p: usize| {
            let [x, first, second] = self.vectors.each_ref().map(|x| x[p]);
            [
                x + 0.5 * first + 0.125 * second,
                first + 0.5 * second,
                second,
            ]
        };
        let middle: Vec<[f64; 3]> = (0..self.vectors[0].len()).map(middle).collect();
        let [v, a, b] = [0, 1, 2].map(|level| {
            let entries: Vec<f64> = middle.iter().map(|x| x[level]).collect();
            size(&entries)
        });
        (v + 0.5 * a + 0.125 * b).max(self.tension.sqrt())
    }

    /// Whether there are rows outside the span.
    pub(crate) fn has_rows(&self) -> bool {
        self.blocks.m + self.blocks.k < self.n
    }
}
