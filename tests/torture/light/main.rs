//! Torture cases 34 to 39: lights, and where sampling them breaks.

mod corridor;
mod environment;
mod polygon;
