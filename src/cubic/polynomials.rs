//! The polynomials that a Riemannian cubic consists of.

use super::riemannian_cubic::RiemannianCubic;

/// One polynomial, in powers of `u = rate (t - center)`.
pub(crate) struct CubicPolynomial<'a> {
    /// Interval on which it is used, in the time of the curve.
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) center: f64,
    pub(crate) rate: f64,
    /// Coefficients of the point, in the coordinates of the frame: columns of `rows` entries, `k` per coefficient.
    pub(crate) points: &'a [f64],
    pub(crate) rows: usize,
    /// Coefficients of `x`: `omega` before `b`, in column-major order.
    pub(crate) vectors: &'a [f64],
}

impl RiemannianCubic {
    /// The polynomials, in the order of the pieces.
    pub(crate) fn polynomials(&self) -> impl Iterator<Item = CubicPolynomial<'_>> {
        let (taylor, time_map) = (&**self.taylor, self.time_map);
        let terms = taylor.accuracy.order + 1;
        let (rows, vector) = (taylor.rows(), taylor.r() * taylor.blocks.k);
        let points = taylor.points.chunks_exact(terms * rows * taylor.blocks.k);
        let vectors = taylor.vectors.chunks_exact(terms * vector);
        let parts = taylor.pieces.iter().zip(points).zip(vectors);
        parts.map(move |((piece, points), vectors)| {
            let time = |taylor_time: f64| {
                time_map.curve_origin + (taylor_time - time_map.taylor_origin) / time_map.rate
            };
            let [a, b] = [piece.lower, piece.upper].map(time);
            CubicPolynomial {
                lower: a.min(b),
                upper: a.max(b),
                center: time(piece.center),
                rate: time_map.rate,
                points,
                rows,
                vectors,
            }
        })
    }
}
