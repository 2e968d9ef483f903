//! Transposed variations: what a sum of products with points of a curve asks of its data.
//!
//! With `p` the displacement of a point in the frame and `w, a, b` the variations of `x, x', x''` beside it, the form
//!
//! ```math
//! \omega(1, 2) = \langle a_1, w_2\rangle - \langle w_1, a_2\rangle - \langle b_1, p_2\rangle + \langle p_1, b_2\rangle
//!     + \langle x'', [p_1, p_2]_m\rangle - \langle [x, x']_h, [p_1, p_2]_h\rangle
//! ```
//!
//! has the same value at all times for two variations of a cubic: the cubics are the critical curves of half the cost, whose
//! boundary terms are `<x', w> - <x'', p>`. So the variation `eta` that jumps by the cotangent `D` in `b` alone at a time gives
//! the product of `D` with the displacement there from the data at any other time,
//!
//! ```math
//! \langle D, p(t)\rangle = -\omega(\eta, \cdot)
//! ```
//!
//! and the same holds for sums: one run back to the start collects all cotangents, whatever their number.
//!
//! In tension the boundary terms are `<x', w> - <x'' - tau x, p>`: `b - tau w` and `x'' - tau x` take the place of `b` and `x''` in
//! `omega`. Where two variations have the same displacement and velocity at a time, their difference is that without tension.
//!
//! # Source
//! Conservation of the symplectic form by Hamiltonian flows: Arnold (1989), "Mathematical Methods of Classical Mechanics", 2nd
//! ed., sec. 38; its boundary form by the second variation: Marsden, West (2001), "Discrete mechanics and variational
//! integrators", Acta Numerica 10, 357-514, sec. 1.2.

use faer::{Mat, MatRef};

use super::end_response::blocks_of;
use super::initial::{Horizontal, InitialData};
use super::reduced::Sized;
use super::taylor::{Accuracy, March};
use super::variation::{Slopes, start};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::dual::Dual;

/// A cotangent at a time after the start, in the coordinates of the frame there; shape `(r, k)`.
pub(super) struct Load {
    pub(super) time: f64,
    pub(super) cotangent: Mat<f64>,
}

/// `(p, w, a, b)` at the start of the variation that jumps by each of the loads.
///
/// # Errors
/// `TooManySteps`, `Overflow`, `Interrupted`.
pub(super) fn collected(
    data: &InitialData,
    loads: &mut [Load],
    interrupt: Interrupt<'_>,
) -> Result<[Horizontal; 4]> {
    let blocks = blocks_of(data);
    // From the latest to the start, and from the earliest.
    loads.sort_by(|one, other| other.time.total_cmp(&one.time));
    let later = loads.partition_point(|load| load.time >= 0.0);
    let (later, earlier) = loads.split_at_mut(later);
    earlier.reverse();
    let mut total = std::array::from_fn(|_| Horizontal::zeros(blocks));
    for side in [&*later, &*earlier] {
        if side.is_empty() {
            continue;
        }
        let found = carried_back(data, side, blocks, interrupt)?;
        for (total, found) in total.iter_mut().zip(&found) {
            *total = std::mem::replace(total, Horizontal::zeros(blocks)).plus(1.0, found);
        }
    }
    Ok(total)
}

/// The same for loads on one side of the start, the farthest first.
fn carried_back(
    data: &InitialData,
    loads: &[Load],
    blocks: Sized,
    interrupt: Interrupt<'_>,
) -> Result<[Horizontal; 4]> {
    let mut march = March::<Dual<1>, Sized>::new(blocks, Accuracy::FULL);
    start(&mut march, data, &[]);
    for load in loads {
        march.run(load.time, interrupt, |_, _, _| Ok(()))?;
        jump(&mut march, load.cotangent.as_ref());
    }
    march.run(0.0, interrupt, |_, _, _| Ok(()))?;
    let mut slopes = Slopes::none(blocks);
    slopes.read(&march, 1);
    let [found] = canonical(&slopes, &[0]).try_into().expect("one direction");
    Ok(found)
}

/// Adds a cotangent to the slope of `x''`.
fn jump(march: &mut March<Dual<1>, Sized>, cotangent: MatRef<'_, f64>) {
    let Sized { m, k } = march.blocks;
    let r = m + k;
    let parts = march.series.parts();
    let product = |column: &[Dual<1>], j: usize| {
        let entries = column.iter().enumerate();
        entries
            .map(|(i, x)| x.value * cotangent[(i, j)])
            .sum::<f64>()
    };
    for j in 0..k {
        for i in 0..k {
            let [one, other] = [[i, j], [j, i]].map(|[i, j]| product(&parts.s[r * i..][..r], j));
            parts.omega[2][i + k * j].slope[0] += one - other;
        }
        for i in 0..m {
            parts.b[2][i + m * j].slope[0] += product(&parts.e[r * i..][..r], j);
        }
    }
}

/// Variations `(p, w, a, b)` in the frame, of some directions: `w` is what is left of that of the velocity after the rotation
/// of everything by which the point is displaced, and so on.
pub(super) fn canonical(slopes: &Slopes, directions: &[usize]) -> Vec<[Horizontal; 4]> {
    let frame = slopes.frame.as_ref();
    let tangents = slopes.state.each_ref().map(Horizontal::tangent);
    let of = |&direction: &usize| {
        let p = Horizontal::of_tangent(frame, slopes.points[direction].as_ref());
        let turn = p.matrix();
        let rest = |level: usize| {
            let all = [&slopes.velocities, &slopes.accelerations, &slopes.seconds];
            let low = frame.transpose() * &all[level][direction] - &turn * &tangents[level];
            let identity = Mat::<f64>::identity(low.nrows(), low.nrows());
            Horizontal::of_tangent(identity.as_ref(), low.as_ref())
        };
        let [w, a, b] = [0, 1, 2].map(rest);
        [p, w, a, b]
    };
    directions.iter().map(of).collect()
}
