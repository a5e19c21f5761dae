//! Torture cases 27 to 33: how surfaces scatter.

mod alpha;
mod cone;
mod energy;
mod extensions;
mod formula;
mod glass;
mod volumes;
