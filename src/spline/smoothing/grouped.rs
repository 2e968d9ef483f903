//! Data grouped by distinct times.

/// Data grouped by distinct times.
pub(crate) struct Grouped {
    /// The distinct times.
    pub(crate) t: Vec<f64>,
    /// Index of the first datum at each.
    pub(crate) first: Vec<usize>,
    /// Index of the distinct time of each datum.
    pub(crate) knots: Vec<usize>,
    /// One per datum.
    pub(crate) weights: Vec<f64>,
}

impl Grouped {
    pub(crate) fn new(t: &[f64], weights: Option<&[f64]>) -> Self {
        let mut grouped = Grouped {
            t: Vec::new(),
            first: Vec::new(),
            knots: Vec::new(),
            weights: weights.map_or_else(|| vec![1.0; t.len()], <[f64]>::to_vec),
        };
        for (i, &t) in t.iter().enumerate() {
            if grouped.t.last() != Some(&t) {
                grouped.t.push(t);
                grouped.first.push(i);
            }
            grouped.knots.push(grouped.t.len() - 1);
        }
        grouped
    }
}
