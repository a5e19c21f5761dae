//! Torture list, accumulation, random numbers and drivers: cases 40 to 44. One test a case, by the
//! list's name.

mod backends;
mod checks;
mod numbers;
mod split_whole;
mod stagnation;
