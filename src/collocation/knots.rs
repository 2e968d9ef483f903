//! Knots in a row: frames, times, and what is given at the ends.

/// What is given at an end of a chain, in coordinates, per unit of time.
#[derive(Debug, Clone)]
pub(crate) enum End {
    Velocity(Vec<f64>),
    Acceleration(Vec<f64>),
}

/// What is given at the ends of a chain.
#[derive(Debug, Clone)]
pub(crate) enum Ends {
    Open([End; 2]),
    Periodic,
}

/// Knots in a row.
pub(crate) struct Knots<'a> {
    /// Of the legs, in units of time.
    pub(crate) lengths: &'a [f64],
    /// The next knot's frame in that of the knot where the leg starts, shape `(r, r)`, column by column.
    pub(crate) targets: Vec<&'a [f64]>,
    pub(crate) ends: &'a Ends,
}

impl<'a> Knots<'a> {
    /// Knots with a velocity of their own: the last one of a closed chain is the first.
    pub(crate) fn count(&self) -> usize {
        self.lengths.len() + usize::from(matches!(self.ends, Ends::Open(_)))
    }

    /// The leg before a knot and the leg after it.
    pub(crate) fn legs_at(&self, knot: usize) -> [Option<usize>; 2] {
        let legs = self.lengths.len();
        let before = match (knot, self.ends) {
            (0, Ends::Periodic) => Some(legs - 1),
            (0, Ends::Open(_)) => None,
            _ => Some(knot - 1),
        };
        [before, (knot < legs).then_some(knot)]
    }

    /// What is given at a knot that is an end, and the sign of its acceleration in a jump.
    pub(crate) fn end_at(&self, knot: usize) -> Option<(&'a End, f64)> {
        match self.ends {
            Ends::Open([first, _]) if knot == 0 => Some((first, 1.0)),
            Ends::Open([_, last]) if knot == self.lengths.len() => Some((last, -1.0)),
            _ => None,
        }
    }

    /// Length of the shorter leg at a knot.
    pub(crate) fn shortest(&self, knot: usize) -> f64 {
        let legs = self.legs_at(knot).into_iter().flatten();
        legs.fold(f64::INFINITY, |h, leg| h.min(self.lengths[leg]))
    }
}
