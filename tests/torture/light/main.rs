//! Torture cases 34 to 39: lights, and where sampling them breaks.

mod caustics;
mod contact;
mod corridor;
mod environment;
mod linearity;
mod polygon;
mod unreachable;
