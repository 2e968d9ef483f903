//! Complex matrices as real ones of twice the size: products, structure, the inverse map, and the defect.

use faer::{Mat, c64};
use stiefel_rs::Error;
use stiefel_rs::linalg::complex_embedding::{
    COMPLEX_TOLERANCE, embed, embedding_defect, paired_columns, restrict, unpaired_columns,
};
use stiefel_rs::linalg::decomp::{Svd, singular_range};

/// Irregular numbers, the same in every run.
fn matrix(rows: usize, cols: usize, seed: u64) -> Mat<c64> {
    let number = |i: usize, j: usize, part: u64| {
        let mixed =
            (seed + 7 * i as u64 + 31 * j as u64 + 101 * part).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    Mat::from_fn(rows, cols, |i, j| {
        c64::new(number(i, j, 0), number(i, j, 1))
    })
}

#[test]
fn embedding_respects_products_and_the_conjugate_transpose() {
    let (a, b) = (matrix(4, 3, 1), matrix(3, 2, 2));
    let product = embed((&a * &b).as_ref());
    let error = (product - embed(a.as_ref()) * embed(b.as_ref())).norm_max();
    // Sums of three products of numbers below 1.
    assert!(error <= 6.0 * f64::EPSILON, "products: {error:e}");
    let adjoint = a.adjoint().to_owned();
    assert_eq!(
        embed(adjoint.as_ref()),
        embed(a.as_ref()).transpose().to_owned()
    );
}

#[test]
fn the_way_back_is_exact() {
    for (rows, cols) in [(1, 1), (3, 1), (4, 4), (5, 2), (0, 0), (3, 0)] {
        let a = matrix(rows, cols, 3);
        assert_eq!(restrict(embed(a.as_ref()).as_ref()).unwrap(), a);
        assert_eq!(embedding_defect(embed(a.as_ref()).as_ref()), 0.0);
    }
}

#[test]
fn the_defect_is_the_distance_from_the_embedded_matrices() {
    let a = matrix(3, 2, 5);
    let mut off = embed(a.as_ref());
    off[(0, 0)] += 2e-6;
    // Each of the two copies receives half of the change.
    let defect = embedding_defect(off.as_ref());
    assert!((defect - 2e-6 / 2_f64.sqrt()).abs() <= 1e-15, "{defect:e}");
    let Err(Error::NotComplex {
        defect: found,
        tolerance,
    }) = restrict(off.as_ref())
    else {
        panic!("a matrix that is not complex was taken");
    };
    assert_eq!(found, defect);
    let norm = off.norm_l2().max(1.0);
    assert!((tolerance - COMPLEX_TOLERANCE * norm).abs() <= 1e-20 + 1e-15 * tolerance);
    off[(0, 0)] -= 2e-6 - 1e-10;
    assert!(restrict(off.as_ref()).is_ok());
}

#[test]
fn numbers_that_are_not_there_stay_so() {
    let missing = Mat::from_fn(4, 2, |_, _| f64::NAN);
    let found = restrict(missing.as_ref()).unwrap();
    assert!((0..2).all(|i| found[(i, 0)].re.is_nan() && found[(i, 0)].im.is_nan()));
}

#[test]
fn triangular_matrices_are_triangular_in_pairs_of_columns() {
    let mut r = matrix(3, 3, 7);
    for j in 0..3 {
        r[(j, j)] = c64::new(1.0 + j as f64, 0.0);
        for i in j + 1..3 {
            r[(i, j)] = c64::new(0.0, 0.0);
        }
    }
    let columns = paired_columns(embed(r.as_ref()).as_ref());
    let both = paired_columns(columns.transpose()).transpose().to_owned();
    for j in 0..6 {
        for i in j + 1..6 {
            assert_eq!(both[(i, j)], 0.0, "entry ({i}, {j})");
        }
        assert!(both[(j, j)] > 0.0);
    }
    let a = embed(matrix(4, 3, 9).as_ref());
    assert_eq!(unpaired_columns(paired_columns(a.as_ref()).as_ref()), a);
}

/// An embedded complex matrix on which faer's iteration stalls: its singular values come in equal pairs.
#[test]
fn svd_of_a_matrix_on_which_the_iteration_stalls() {
    let top = [
        [
            -1.243219791014563,
            -1.3438464457085337,
            0.42647282173796025,
            0.21630054991006462,
            1.605776779487397,
            -0.06485332900248938,
        ],
        [
            -0.7132633476836574,
            -1.4590990184674946,
            -0.7207715670394585,
            0.20111172411980055,
            0.5251356475921335,
            -0.8648580848591221,
        ],
        [
            1.294176651844279,
            -0.4930218080433588,
            1.2686291111120434,
            2.0855957678201205,
            0.5728653270146665,
            0.23348011604442434,
        ],
    ];
    let a = Mat::from_fn(6, 6, |i, j| match i {
        0..3 => top[i][j],
        _ if j < 3 => -top[i - 3][j + 3],
        _ => top[i - 3][j - 3],
    });
    for columns in [6, 5] {
        let a = a.subcols(0, columns);
        let mut svd = Svd::new(6, columns);
        svd.compute(a).unwrap();
        let scaled = Mat::from_fn(6, columns, |i, j| svd.u()[(i, j)] * svd.s(j));
        let product = scaled * svd.v().transpose();
        // Backward error: a few units of round-off for each of six columns.
        let error = (product - a).norm_max();
        assert!(
            error <= 60.0 * f64::EPSILON * svd.s(0),
            "A = U S V^T: {error:e}"
        );
        let gram = svd.v().transpose() * svd.v();
        let error = (gram - Mat::<f64>::identity(columns, columns)).norm_max();
        assert!(error <= 60.0 * f64::EPSILON, "V^T V = I: {error:e}");
        let [smallest, largest] = singular_range(a).unwrap();
        assert!(
            (largest - svd.s(0)).abs() <= 1e-14 && (smallest - svd.s(columns - 1)).abs() <= 1e-14
        );
    }
}
