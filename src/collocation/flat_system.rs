//! The tridiagonal system of cubic splines in flat space.

use crate::error::{Error, Result};
use crate::legs::{Ends, Knots};
use crate::solve::tridiagonal::{Isometries, Row, Shape, Tridiagonal, Way};

/// Vectors are not turned between knots.
pub(super) struct Unturned(pub(super) usize);

impl Isometries for Unturned {
    fn size(&self) -> usize {
        self.0
    }

    fn carry_into(&mut self, _: usize, _: Way, from: &[f64], to: &mut [f64]) -> Result<()> {
        to.copy_from_slice(from);
        Ok(())
    }
}

/// The system of cubic splines for the changes of the velocities:
///
/// ```math
/// \frac{2}{h_-} dv_{j-1} + \Bigl(\frac{4}{h_-} + \frac{4}{h_+}\Bigr) dv_j + \frac{2}{h_+} dv_{j+1} = -[S'']
/// ```
pub(super) fn system(knots: &Knots<'_>) -> Result<Tridiagonal<1>> {
    let row = |knot: usize| {
        let mut row = Row::ZERO;
        if knots.is_fixed(knot) {
            row.diagonal = [[1.0]];
            return row;
        }
        let [before, after] = knots.legs_at(knot);
        if let Some(leg) = before {
            row.below[0][0] = 2.0 / knots.lengths[leg];
            row.diagonal[0][0] += 4.0 / knots.lengths[leg];
        }
        if let Some(leg) = after {
            row.above[0][0] = 2.0 / knots.lengths[leg];
            row.diagonal[0][0] += 4.0 / knots.lengths[leg];
        }
        row
    };
    let rows: Vec<Row<1>> = (0..knots.count()).map(row).collect();
    let shape = match knots.ends {
        Ends::Open(_) => Shape::Open,
        Ends::Periodic => Shape::Closed,
    };
    Tridiagonal::new(&rows, shape).ok_or(Error::Overflow {
        quantity: "system of a spline",
    })
}
