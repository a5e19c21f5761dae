//! Torture list, geometry: cases 9 to 19. One test a case, by the list's name.

mod respawn;
mod walk;
