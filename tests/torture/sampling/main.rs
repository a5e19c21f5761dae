//! Torture cases 20 to 26: what is sampled, and what error bars make of it.

mod adaptive;
mod chi2;
mod coverage;
mod depth;
mod forms;
mod path_reuse;
mod roulette;
mod slope;
mod stopping;
