//! Vectors of `m` packed as coordinates.

use super::blocks::Sizes;
use super::initial::Horizontal;
use crate::space::{Homogeneous, in_space};

/// The coordinates of vectors of `m`, one vector after another: for real vectors the entries of `omega` above the
/// diagonal (unless `omega` is always zero), then the entries of `normal`.
pub(crate) fn pack(blocks: Sizes, vectors: &[Horizontal]) -> Vec<f64> {
    let (k, d) = (blocks.k, blocks.dim());
    let mut all = vec![0.0; d * vectors.len()];
    for (n, vector) in vectors.iter().enumerate() {
        let y = &mut all[d * n..];
        in_space!(blocks.shape(), |space| space.each_entry(|p, i, j| {
            let entry = match i.checked_sub(k) {
                None => vector.omega[(i, j)],
                Some(i) => vector.normal[(i, j)],
            };
            y[p] = entry * space.scale(i, j);
        }));
    }
    all
}

/// The coordinates of a real vector from its blocks: `omega`, then `normal`, in column-major order.
pub(crate) fn pack_blocks(blocks: Sizes, x: &[f64], out: &mut [f64]) {
    let Sizes { m, k, .. } = blocks;
    in_space!(blocks.shape(), |space| space.each_entry(|p, i, j| {
        out[p] = match i.checked_sub(k) {
            None => x[i + k * j],
            Some(i) => x[k * k + i + m * j],
        };
    }));
}

/// The gradient with respect to coordinates of a real vector, from the one with respect to its tangent vector at the
/// identity, whose entries are `entry(i, j)`, shape `(m + k, k)`.
pub(crate) fn pack_gradient(blocks: Sizes, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut gradient = vec![0.0; blocks.dim()];
    in_space!(blocks.shape(), |space| space.each_entry(|p, i, j| {
        // Each entry of `omega` occurs twice.
        gradient[p] = match i < blocks.k {
            true => entry(i, j) - entry(j, i),
            false => entry(i, j),
        };
    }));
    gradient
}

/// The inverse of [`pack`].
pub(crate) fn unpack<const N: usize>(y: &[f64], blocks: Sizes) -> [Horizontal; N] {
    let (k, d) = (blocks.k, blocks.dim());
    std::array::from_fn(|n| {
        let y = &y[d * n..];
        let mut vector = Horizontal::zeros(blocks);
        let mut write = |i: usize, j: usize, entry: f64| match i.checked_sub(k) {
            None => {
                vector.omega[(i, j)] = entry;
                vector.omega[(j, i)] = -entry;
            }
            Some(i) => vector.normal[(i, j)] = entry,
        };
        in_space!(blocks.shape(), |space| space.each_entry(|p, i, j| {
            let entry = y[p] / space.scale(i, j);
            write(i, j, entry);
            if let Some(([i, j], sign)) = space.copy_of(i, j) {
                write(i, j, entry * sign);
            }
        }));
        vector
    })
}

/// Writes the vector `[omega; b]` with the given coordinates, or all of `[[omega, -b^T], [b, 0]]` if there is room for
/// it.
pub(crate) fn write_vector(out: &mut [f64], v: &[f64], r: usize, blocks: Sizes) {
    let columns = out.len() / r;
    out.fill(0.0);
    let mut write = |i: usize, j: usize, entry: f64| {
        for ([i, j], entry) in [([i, j], entry), ([j, i], -entry)] {
            if j < columns {
                out[i + r * j] = entry;
            }
        }
    };
    in_space!(blocks.shape(), |space| space.each_entry(|p, i, j| {
        let entry = v[p] / space.scale(i, j);
        write(i, j, entry);
        if let Some(([i, j], sign)) = space.copy_of(i, j) {
            write(i, j, entry * sign);
        }
    }));
}

/// Coordinates of the horizontal part of a vector at the first columns of the identity, by columns.
pub(crate) fn read_vector(vector: &[f64], out: &mut [f64], r: usize, blocks: Sizes) {
    read_entries(|i, j| vector[i + r * j], out, blocks);
}

/// The same for a vector with the given entries.
pub(crate) fn read_entries(entry: impl Fn(usize, usize) -> f64, out: &mut [f64], blocks: Sizes) {
    let k = blocks.k;
    in_space!(blocks.shape(), |space| space.each_entry(|p, i, j| {
        let entry = match i < k {
            true => 0.5 * (entry(i, j) - entry(j, i)),
            false => entry(i, j),
        };
        out[p] = entry * space.scale(i, j);
    }));
}
