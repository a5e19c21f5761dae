//! Torture cases 20 to 26: sampling, and error bars.

mod adaptive;
mod chi2;
mod coverage;
mod depth;
mod forms;
mod path_reuse;
mod roulette;
mod slope;
mod stopping;
