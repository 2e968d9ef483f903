//! The numbers that a Riemannian cubic consists of: to store it, and to have the very same curve back.

use std::sync::Arc;

use faer::Mat;

use super::clock::Clock;
use super::path::{Path, Piece, State};
use super::reduced::{Blocks, Sized};
use super::riemannian_cubic::RiemannianCubic;
use super::taylor::Accuracy;
use crate::error::{Error, Result};
use crate::linalg::structure::{check_finite, check_finite_scalar};

const NAME: &str = "stored curve";

/// A Riemannian cubic without its report.
pub(crate) struct Stored {
    /// `n`, `k`, and the dimension of the span less `k`.
    pub(crate) sizes: [usize; 3],
    pub(crate) tolerance: f64,
    /// Basis of the span, shape `(n, r)`; none where that is all of `R^n`.
    pub(crate) frame: Option<Mat<f64>>,
    /// Beginning, end and center of every piece.
    pub(crate) pieces: Vec<[f64; 3]>,
    /// Coefficients of the point, piece by piece.
    pub(crate) points: Vec<f64>,
    /// Coefficients of `x`.
    pub(crate) vectors: Vec<f64>,
    /// Time, frame, `x`, `x'` and `x''` at both ends.
    pub(crate) ends: [Vec<f64>; 2],
    /// Rate, a moment of the curve, and the same one of the path.
    pub(crate) clock: [f64; 3],
    pub(crate) span: [f64; 2],
}

impl RiemannianCubic {
    /// The numbers of the curve.
    pub(crate) fn stored(&self) -> Stored {
        let path = &self.path;
        let end = |state: &State| [&[state.time][..], &state.entries].concat();
        let piece = |piece: &Piece| [piece.lower, piece.upper, piece.center];
        Stored {
            sizes: [self.n, self.k, path.blocks.m],
            tolerance: self.tolerance(),
            frame: self.frame.as_deref().cloned(),
            pieces: path.pieces.iter().map(piece).collect(),
            points: path.points.clone(),
            vectors: path.vectors.clone(),
            ends: [end(&path.first), end(&path.last)],
            clock: [self.clock.rate, self.clock.curve, self.clock.path],
            span: [self.span.0, self.span.1],
        }
    }

    /// The curve of the numbers, the same to the last bit.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `InvalidArgument` (a tolerance out of range, times out of order).
    pub(crate) fn of_stored(stored: Stored) -> Result<Self> {
        let [n, k, _] = stored.sizes;
        let clock = stored.clock()?;
        let span = stored.span()?;
        let frame = stored.frame()?.map(Arc::new);
        Ok(RiemannianCubic {
            n,
            k,
            frame,
            path: Arc::new(stored.path()?),
            clock,
            span,
            report: None,
            boundary_report: None,
        })
    }
}

impl Stored {
    /// Sizes of the blocks, after a check of those of the curve.
    fn blocks(&self) -> Result<Sized> {
        let [n, k, m] = self.sizes;
        let rows = match &self.frame {
            Some(frame) if frame.nrows() == n => frame.ncols(),
            Some(frame) => return Err(size_error("frame", n, frame.nrows())),
            None => n,
        };
        match k.checked_add(m) {
            Some(r) if k >= 1 && r <= n && r == rows => Ok(Sized { m, k }),
            _ => Err(size_error("span", k.saturating_add(m), rows)),
        }
    }

    fn frame(&self) -> Result<Option<Mat<f64>>> {
        if let Some(frame) = &self.frame {
            check_finite(NAME, frame.as_ref())?;
        }
        Ok(self.frame.clone())
    }

    fn clock(&self) -> Result<Clock> {
        let [rate, curve, path] = self.clock;
        check_finite_scalar(NAME, curve)?;
        check_finite_scalar(NAME, path)?;
        if !rate.is_normal() {
            return Err(invalid("of a rate that is a normal number", rate));
        }
        Ok(Clock { rate, curve, path })
    }

    fn span(&self) -> Result<(f64, f64)> {
        let [start, end] = self.span;
        check_finite_scalar(NAME, start)?;
        check_finite_scalar(NAME, end)?;
        if start < end && (end - start).is_finite() {
            return Ok((start, end));
        }
        Err(invalid("over an interval that ends after its start", end))
    }

    fn path(self) -> Result<Path> {
        let blocks = self.blocks()?;
        let range = Accuracy::FULL.truncation..=0.1;
        if !range.contains(&self.tolerance) {
            return Err(invalid(
                "of a tolerance between 1e-17 and 0.1",
                self.tolerance,
            ));
        }
        let accuracy = Accuracy::of_tolerance(self.tolerance);
        check_pieces(&self.pieces)?;
        let Sized { m, k } = blocks;
        let (r, count) = (m + k, self.pieces.len());
        let orders = count.checked_mul(accuracy.order + 1);
        let product = |a: usize, b: usize| orders?.checked_mul(a)?.checked_mul(b);
        check_entries("points", &self.points, product(blocks.r::<f64>(), k))?;
        check_entries("vectors", &self.vectors, product(r, k))?;
        let [first, last] = self.ends;
        let state = |numbers: Vec<f64>| -> Result<State> {
            let size = r
                .checked_mul(r.saturating_add(k.saturating_mul(3)))
                .and_then(|size| size.checked_add(1));
            check_entries("ends", &numbers, size)?;
            Ok(State {
                time: numbers[0],
                blocks,
                entries: numbers[1..].to_vec(),
            })
        };
        let (first, last) = (state(first)?, state(last)?);
        if first.time > last.time {
            return Err(invalid("of times in order", last.time));
        }
        let piece = |[lower, upper, center]: [f64; 3]| Piece {
            lower,
            upper,
            center,
        };
        Ok(Path {
            blocks,
            accuracy,
            pieces: self.pieces.into_iter().map(piece).collect(),
            points: self.points,
            vectors: self.vectors,
            first,
            last,
        })
    }
}

/// Error unless there is a piece, all times are finite, and the pieces follow one another.
fn check_pieces(pieces: &[[f64; 3]]) -> Result<()> {
    if pieces.is_empty() {
        return Err(size_error("pieces", 1, 0));
    }
    for (i, piece) in pieces.iter().enumerate() {
        for time in piece {
            check_finite_scalar(NAME, *time)?;
        }
        let before = i.checked_sub(1).map_or(piece[0], |i| pieces[i][1]);
        if piece[0] > piece[1] || before > piece[1] {
            return Err(invalid("of times in order", piece[1]));
        }
    }
    Ok(())
}

/// Error unless there are as many entries as that, all finite.
fn check_entries(what: &str, entries: &[f64], expected: Option<usize>) -> Result<()> {
    let expected = expected.unwrap_or(usize::MAX);
    if entries.len() != expected {
        return Err(size_error(what, expected, entries.len()));
    }
    match entries.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::NonFinite { name: NAME, index }),
    }
}

fn size_error(what: &str, expected: usize, found: usize) -> Error {
    Error::Shape {
        name: NAME,
        expected: format!("({expected},) of its {what}"),
        found: format!("({found},)"),
    }
}

fn invalid(requirement: &'static str, found: f64) -> Error {
    Error::InvalidArgument {
        name: NAME,
        requirement,
        found,
    }
}
