//! Torture list, numbers: cases 1 to 8. One test a case, by the list's name.

mod far_origin;
mod furnace;
