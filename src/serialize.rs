//! The serde representation of stored curves: format, version, kind, and the arrays by name.

use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, GeometricPolynomial, SubspacePolynomial};
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifold::{Geodesic, QuasiGeodesic};
use crate::spline::Piecewise;
use crate::stored::{Array, FORMAT, Fields, Stored, VERSION, check_header, refusal};

#[derive(Serialize, Deserialize)]
struct SerdeForm {
    format: String,
    version: u64,
    kind: String,
    arrays: BTreeMap<String, Array>,
}

fn serialize<C: Stored, S: Serializer>(curve: &C, serializer: S) -> Result<S::Ok, S::Error> {
    let mut fields = Fields::default();
    curve.store(&mut fields);
    let form = SerdeForm {
        format: FORMAT.to_owned(),
        version: VERSION,
        kind: C::KIND.to_owned(),
        arrays: fields.0,
    };
    form.serialize(serializer)
}

fn deserialize<'de, C: Stored, D: Deserializer<'de>>(deserializer: D) -> Result<C, D::Error> {
    let form = SerdeForm::deserialize(deserializer)?;
    restored(form).map_err(D::Error::custom)
}

fn restored<C: Stored>(form: SerdeForm) -> Result<C, Error> {
    check_header(&form.format, form.version)?;
    if form.kind != C::KIND {
        let (expected, found) = (C::KIND, form.kind);
        return Err(refusal(format!(
            "expected a '{expected}', found a '{found}'"
        )));
    }
    Fields(form.arrays).read(|fields| C::restore(fields, Interrupt::NEVER))
}

macro_rules! stored_by_serde {
    ($($curve:ty),*) => {$(
        impl Serialize for $curve {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serialize(self, serializer)
            }
        }

        impl<'de> Deserialize<'de> for $curve {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserialize(deserializer)
            }
        }
    )*};
}

stored_by_serde!(
    QuasiGeodesic,
    Geodesic,
    GeometricPolynomial,
    GeometricCubic,
    SubspacePolynomial,
    RiemannianCubic,
    Piecewise<GeometricCubic>,
    Piecewise<SubspacePolynomial>,
    Piecewise<RiemannianCubic>
);
