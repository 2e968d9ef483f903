//! The equation of cubics along a curve, and its linearisation, at eight nodes.

use crate::linalg::lanes::Lanes;
use crate::space::Homogeneous;

/// A curve at eight nodes.
pub(crate) struct Along {
    /// Skew matrices of `x, x', x''`.
    pub(crate) x: [Vec<Lanes>; 3],
    /// `[x, x']_h` and its negative.
    pub(crate) turning: [Vec<Lanes>; 2],
}

impl Along {
    /// A curve at rest.
    pub(crate) fn new(space: impl Homogeneous) -> Self {
        let zeros = |count: usize| vec![Lanes::ZERO; count];
        Along {
            x: std::array::from_fn(|_| zeros(space.size().pow(2))),
            turning: std::array::from_fn(|_| zeros(space.isotropy_dim())),
        }
    }

    /// Sets the curve from coordinates of `x, x', x''`.
    #[inline(always)]
    pub(crate) fn set(&mut self, space: impl Homogeneous, x: [&[Lanes]; 3]) {
        for (matrix, x) in self.x.iter_mut().zip(x) {
            space.matrix_into(x, matrix);
        }
        let [x, x1, _] = &self.x;
        for (turning, sign) in self.turning.iter_mut().zip([1.0, -1.0]) {
            turning.fill(Lanes::ZERO);
            space.add_isotropy_bracket(x, x1, sign, turning);
        }
    }

    /// Adds the brackets of the equation, `[x'', x]_m - [[x, x']_h, x]`.
    #[inline(always)]
    pub(crate) fn add_brackets(&self, space: impl Homogeneous, out: &mut [Lanes]) {
        let [x, _, x2] = &self.x;
        if !space.is_symmetric() {
            space.add_bracket(x2, x, 1.0, out);
        }
        if space.isotropy_dim() > 0 {
            space.subtract_action(&self.turning[0], x, out);
        }
    }

    /// Adds their change, from the matrices of the changes `w, a, b` of `x, x', x''`; `z` holds an element of `h`.
    #[inline(always)]
    pub(crate) fn add_change(
        &self,
        space: impl Homogeneous,
        [w, a, b]: [&[Lanes]; 3],
        z: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        let [x, x1, x2] = &self.x;
        if !space.is_symmetric() {
            space.add_bracket(b, x, 1.0, out);
            space.add_bracket(x2, w, 1.0, out);
        }
        if space.isotropy_dim() > 0 {
            z.fill(Lanes::ZERO);
            space.add_isotropy_bracket(w, x1, 1.0, z);
            space.add_isotropy_bracket(x, a, 1.0, z);
            space.subtract_action(z, x, out);
            space.subtract_action(&self.turning[0], w, out);
        }
    }

    /// The transpose of [`add_change`](Along::add_change), from the matrix of the gradient with respect to its result:
    /// `<[p, x], q> = <p, [x, q]>`; `z` holds an element of `h`.
    #[inline(always)]
    pub(crate) fn add_change_transposed(
        &self,
        space: impl Homogeneous,
        f: &[Lanes],
        z: &mut [Lanes],
        [by_w, by_a, by_b]: [&mut [Lanes]; 3],
    ) {
        let [x, x1, x2] = &self.x;
        if !space.is_symmetric() {
            space.add_bracket(x, f, 1.0, by_b);
            space.add_bracket(f, x2, 1.0, by_w);
        }
        if space.isotropy_dim() > 0 {
            z.fill(Lanes::ZERO);
            space.add_isotropy_bracket(x, f, 1.0, z);
            space.subtract_action(z, x, by_a);
            z.iter_mut().for_each(|z| *z = -*z);
            space.subtract_action(z, x1, by_w);
            space.subtract_action(&self.turning[1], f, by_w);
        }
    }
}
