//! The polynomials that a Riemannian cubic consists of.

use super::riemannian_cubic::RiemannianCubic;

/// One polynomial, in powers of `u = rate (t - center)`.
pub(crate) struct Polynomial<'a> {
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
    /// The polynomials, in the order of the path.
    pub(crate) fn polynomials(&self) -> impl Iterator<Item = Polynomial<'_>> {
        let (path, clock) = (&**self.path, self.clock);
        let terms = path.accuracy.order + 1;
        let (rows, vector) = (path.rows(), path.r() * path.blocks.k);
        let points = path.points.chunks_exact(terms * rows * path.blocks.k);
        let vectors = path.vectors.chunks_exact(terms * vector);
        let parts = path.pieces.iter().zip(points).zip(vectors);
        parts.map(move |((piece, points), vectors)| {
            let time = |path_time: f64| clock.curve + (path_time - clock.path) / clock.rate;
            let [a, b] = [piece.lower, piece.upper].map(time);
            Polynomial {
                lower: a.min(b),
                upper: a.max(b),
                center: time(piece.center),
                rate: clock.rate,
                points,
                rows,
                vectors,
            }
        })
    }
}
