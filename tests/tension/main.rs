//! Cubics in tension: the equation, conserved quantities, closed forms on a circle, boundary problems, splines,
//! splittings.

#[path = "../common/boundary.rs"]
mod boundary_data;
#[path = "../common/mod.rs"]
mod common;

mod boundary;
mod circle;
mod derivatives;
mod initial;
mod input;
mod splines;
