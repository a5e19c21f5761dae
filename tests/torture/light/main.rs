//! Torture cases 34 to 39: lights, and where sampling them breaks.

mod caustics;
mod contact;
mod corridor;
mod emitters;
mod environment;
mod linearity;
mod panes;
mod polygon;
mod transparent;
mod unreachable;
