//! Stored form of Riemannian cubics, from which the same curves are restored bit for bit.

use std::sync::Arc;

use faer::Mat;

use super::riemannian_cubic::RiemannianCubic;
use super::stored_check::check_taylor;
use super::taylor::blocks::{BlockSizes, Sizes};
use super::taylor::march::Accuracy;
use super::taylor::piecewise_taylor::{PiecewiseTaylor, TaylorPiece};
use super::taylor::state::State;
use super::tension::check_tension;
use super::time_map::TimeMap;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::stored::{check_orthonormal, quotient_of};
use crate::space::Quotient;
use crate::stored::{
    Fields, Parts, READER, REPORTS, Stored, StoredPiece, extend, only, product, refusal,
};

impl Stored for RiemannianCubic {
    const KIND: &'static str = "RiemannianCubic";

    fn store(&self, fields: &mut Fields) {
        Self::store_all(std::slice::from_ref(self), fields);
    }

    fn restore(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Self> {
        only(Self::restore_all(fields, interrupt)?)
    }
}

impl StoredPiece for RiemannianCubic {
    const SPLINE: &'static str = "spline of RiemannianCubic";

    fn store_all(curves: &[Self], fields: &mut Fields) {
        let first = curves.first();
        fields.put_whole("shape", first.map_or([0, 0], |first| [first.n, first.k]));
        let polynomials = || curves.iter().map(|curve| &*curve.taylor);
        let flat = |numbers: &dyn Fn(&Self) -> Vec<f64>| curves.iter().flat_map(numbers).collect();
        fields.put_whole(
            "ranks",
            polynomials().map(|taylor| taylor.blocks.m + taylor.blocks.k),
        );
        fields.put_whole("steps", polynomials().map(|taylor| taylor.pieces.len()));
        fields.put_whole("orders", polynomials().map(|taylor| taylor.accuracy.order));
        fields.put_flat("tolerances", flat(&|curve| vec![curve.tolerance()]));
        fields.put_flat(
            "clocks",
            flat(&|curve| {
                vec![
                    curve.time_map.rate,
                    curve.time_map.curve_origin,
                    curve.time_map.taylor_origin,
                ]
            }),
        );
        if polynomials().any(|taylor| taylor.tension() != 0.0) {
            fields.put_flat("tensions", flat(&|curve| vec![curve.taylor.tension()]));
        }
        if polynomials().any(|taylor| taylor.quotient() == Quotient::Subspaces) {
            let is_subspace = |curve: &Self| curve.taylor.quotient() == Quotient::Subspaces;
            fields.put_flat(
                "subspaces",
                flat(&|curve| vec![f64::from(is_subspace(curve))]),
            );
        }
        fields.put_flat("spans", flat(&|curve| vec![curve.span.0, curve.span.1]));
        let interval = |piece: &TaylorPiece| [piece.lower, piece.upper, piece.center];
        let intervals = polynomials().flat_map(|taylor| taylor.pieces.iter().flat_map(interval));
        fields.put_flat("intervals", intervals.collect());
        fields.put_flat("points", flat(&|curve| curve.taylor.points.clone()));
        fields.put_flat("vectors", flat(&|curve| curve.taylor.vectors.clone()));
        let end = |state: &State| [&[state.time][..], &state.entries].concat();
        fields.put_flat(
            "ends",
            flat(&|curve| [end(&curve.taylor.first), end(&curve.taylor.last)].concat()),
        );
        fields.put_reports(REPORTS, curves.iter().map(|curve| curve.report));
        store_frames(curves, fields);
    }

    fn restore_all(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Vec<Self>> {
        let [n, k] = fields.some_whole("shape")?;
        let steps = fields.whole("steps")?;
        let count = steps.len();
        let ranks = fields.whole_each("ranks", count)?;
        let orders = fields.whole_each("orders", count)?;
        let frames = restore_frames(n, count, fields)?;
        let reports = fields.reports(REPORTS, count)?;
        let names = ["tolerances", "clocks", "spans"];
        let [mut tolerances, mut clocks, mut spans] = parts(names, fields)?;
        let mut tensions = fields.parts_or_zeros("tensions", count)?;
        let mut subspaces = fields.parts_or_zeros("subspaces", count)?;
        let names = ["intervals", "points", "vectors", "ends"];
        let mut numbers = StoredNumbers(parts(names, fields)?);
        let mut curves = Vec::with_capacity(count);
        for (i, (frame, report)) in frames.into_iter().zip(reports).enumerate() {
            interrupt.check(READER)?;
            let rows = frame.as_ref().map_or(n, |frame| frame.ncols());
            let [subspace] = subspaces.some()?;
            let blocks = blocks(n, k, ranks[i], rows, subspace)?;
            let [tolerance] = tolerances.some()?;
            let (time_map, span) = (time_map(clocks.some()?)?, span(spans.some()?)?);
            let [tension] = tensions.some()?;
            check_tension(tension)?;
            let taylor = numbers.next_curve(blocks, steps[i], orders[i], [tolerance, tension])?;
            check_taylor(&taylor, interrupt)?;
            curves.push(RiemannianCubic {
                n,
                k,
                frame,
                taylor: Arc::new(taylor.into()),
                time_map,
                span,
                report,
            });
        }
        for rest in [tolerances, clocks, spans, tensions, subspaces]
            .into_iter()
            .chain(numbers.0)
        {
            rest.end()?;
        }
        Ok(curves)
    }
}

fn parts<const N: usize>(names: [&'static str; N], fields: &mut Fields) -> Result<[Parts; N]> {
    let parts = names
        .into_iter()
        .map(|name| fields.parts(name))
        .collect::<Result<Vec<_>>>()?;
    Ok(<[Parts; N]>::try_from(parts).unwrap_or_else(|_| unreachable!("as many as names")))
}

/// Stores each basis of a span once, and for every curve the index of its basis, counted from 1; 0 for none.
fn store_frames(curves: &[RiemannianCubic], fields: &mut Fields) {
    let mut distinct: Vec<&Arc<Mat<f64>>> = Vec::new();
    let mut own = Vec::with_capacity(curves.len());
    for curve in curves {
        // Pieces of a spline share a basis only with earlier pieces.
        own.push(match &curve.frame {
            None => 0,
            Some(frame) => {
                if !distinct.last().is_some_and(|last| Arc::ptr_eq(last, frame)) {
                    distinct.push(frame);
                }
                distinct.len()
            }
        });
    }
    let mut entries = Vec::new();
    for frame in &distinct {
        extend(&mut entries, frame.as_ref().as_ref());
    }
    fields.put_whole("frame_of", own);
    fields.put_whole("frame_ranks", distinct.iter().map(|frame| frame.ncols()));
    fields.put_flat("frames", entries);
}

fn restore_frames(
    n: usize,
    count: usize,
    fields: &mut Fields,
) -> Result<Vec<Option<Arc<Mat<f64>>>>> {
    let ranks = fields.whole("frame_ranks")?;
    let mut entries = fields.parts("frames")?;
    let frames = ranks
        .into_iter()
        .map(|rank| {
            let frame = entries.matrix(n, rank)?;
            check_orthonormal("frames", frame.as_ref())?;
            Ok(Arc::new(frame))
        })
        .collect::<Result<Vec<_>>>()?;
    entries.end()?;
    let own = fields.whole_each("frame_of", count)?;
    own.into_iter()
        .map(|own| match own.checked_sub(1).map(|own| frames.get(own)) {
            None => Ok(None),
            Some(Some(frame)) => Ok(Some(Arc::clone(frame))),
            Some(None) => Err(refusal(format!("frame_of: there is no basis {own}"))),
        })
        .collect()
}

/// Block sizes, after checking them against the sizes of the curve.
fn blocks(n: usize, k: usize, rank: usize, rows: usize, subspace: f64) -> Result<Sizes> {
    let quotient = quotient_of([subspace])?;
    if k >= 1 && k <= rank && rank <= n && rank == rows {
        return Ok(Sizes::new(rank - k, k, quotient));
    }
    Err(refusal(format!(
        "a point of shape ({n}, {k}) in {rank} dimensions, found {rows}"
    )))
}

fn time_map([rate, curve_origin, taylor_origin]: [f64; 3]) -> Result<TimeMap> {
    if rate.is_normal() {
        return Ok(TimeMap {
            rate,
            curve_origin,
            taylor_origin,
        });
    }
    Err(refusal(format!("clocks: {rate} is not a valid rate")))
}

fn span([start, end]: [f64; 2]) -> Result<(f64, f64)> {
    if start < end && (end - start).is_finite() {
        return Ok((start, end));
    }
    Err(refusal(format!(
        "spans: invalid interval from {start} to {end}"
    )))
}

/// Orders of polynomials that can be extended. Fast legs of splines have orders up to 70.
const ORDERS: std::ops::RangeInclusive<usize> = 3..=128;

/// Intervals, coefficients of points, coefficients of vectors, and end states of consecutive pieces.
struct StoredNumbers([Parts; 4]);

impl StoredNumbers {
    fn next_curve(
        &mut self,
        blocks: Sizes,
        count: usize,
        order: usize,
        [tolerance, tension]: [f64; 2],
    ) -> Result<PiecewiseTaylor> {
        let range = Accuracy::FULL.truncation..=0.1;
        if !range.contains(&tolerance) {
            return Err(refusal(format!("tolerances: {tolerance} is out of range")));
        }
        if !ORDERS.contains(&order) {
            return Err(refusal(format!("orders: {order} is out of range")));
        }
        let accuracy = Accuracy {
            order,
            ..Accuracy::of_tolerance(tolerance)
        };
        let [intervals, points, vectors, ends] = &mut self.0;
        let pieces = pieces(intervals.next(product(&[3, count]))?)?;
        let (r, k) = (blocks.m + blocks.k, blocks.k);
        let rows = blocks.r::<f64>();
        let coefficients = |rows| product(&[count, accuracy.order + 1, rows, k]);
        let points = points.next(coefficients(rows))?.to_vec();
        let vectors = vectors.next(coefficients(r))?.to_vec();
        let size = product(&[3, k])
            .and_then(|columns| columns.checked_add(r))
            .and_then(|columns| product(&[r, columns]));
        let mut state = || -> Result<State> {
            let [time] = ends.some()?;
            let entries = ends.next(size)?.to_vec();
            Ok(State::of_entries(blocks, time, entries).in_tension(tension))
        };
        let (first, last) = (state()?, state()?);
        if first.time > last.time {
            let (first, last) = (first.time, last.time);
            return Err(refusal(format!(
                "ends: times not increasing, {first} and {last}"
            )));
        }
        Ok(PiecewiseTaylor {
            blocks,
            accuracy,
            pieces,
            points,
            vectors,
            first,
            last,
        })
    }
}

/// Return an error unless there is at least one piece and the pieces are contiguous.
fn pieces(intervals: &[f64]) -> Result<Vec<TaylorPiece>> {
    if intervals.is_empty() {
        return Err(refusal("steps: the curve has none".to_owned()));
    }
    let mut before = intervals[0];
    let piece = |numbers: &[f64]| {
        let (lower, upper, center) = (numbers[0], numbers[1], numbers[2]);
        if lower > upper || before > upper {
            return Err(refusal(format!(
                "intervals: times not increasing at {upper}"
            )));
        }
        before = upper;
        Ok(TaylorPiece {
            lower,
            upper,
            center,
        })
    };
    intervals.chunks_exact(3).map(piece).collect()
}
