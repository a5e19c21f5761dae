//! Sampling of lights: which one, and where on it, follow the pdf that is claimed; the value is the
//! light's over that pdf.

mod choice;
mod lamps;
mod points;
mod tree;
