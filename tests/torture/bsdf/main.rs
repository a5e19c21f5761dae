//! Torture cases 27 to 33: how surfaces scatter.

mod energy;
mod formula;
mod glass;
