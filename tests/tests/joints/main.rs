//! What every kind of joint does: limits, drives, partners, refusals, and bits.

mod api;
mod bits;
mod drives;
mod iterative;
mod leapfrog;
mod limits;
mod meeting;
mod partners;
mod plain;
mod robust;
