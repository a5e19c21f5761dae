//! Torture list, numbers: cases 1 to 8. One test a case, by the list's name.

mod endpoints;
mod far_origin;
mod furnace;
mod quarantine;
mod scales;
