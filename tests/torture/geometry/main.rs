//! Torture list, geometry: cases 9 to 19. One test a case, by the list's name.

mod clip;
mod closed;
mod defects;
mod instances;
mod normals;
mod respawn;
mod traversal;
