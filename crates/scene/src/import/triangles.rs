//! Primitive modes: triangle lists, strips and fans, with or without indices, as one list of
//! triangles.

use gltf::json::mesh;

use super::document::Int;

/// The modes that have area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Mode {
    List,
    Strip,
    Fan,
}

/// The meaning of a primitive's `mode`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Triangles(Mode),
    /// Points and lines have no area.
    Thin,
    Unknown,
}

pub(crate) fn kind(mode: Option<Int>) -> Kind {
    match mode.map_or(Ok(mesh::TRIANGLES), |m| u32::try_from(m.0)) {
        Ok(mesh::POINTS | mesh::LINES | mesh::LINE_LOOP | mesh::LINE_STRIP) => Kind::Thin,
        Ok(mesh::TRIANGLES) => Kind::Triangles(Mode::List),
        Ok(mesh::TRIANGLE_STRIP) => Kind::Triangles(Mode::Strip),
        Ok(mesh::TRIANGLE_FAN) => Kind::Triangles(Mode::Fan),
        _ => Kind::Unknown,
    }
}

impl Mode {
    /// Triangles that `corners` corners make.
    pub(crate) fn triangles_of(self, corners: usize) -> usize {
        match self {
            Self::List => corners / 3,
            Self::Strip | Self::Fan => corners.saturating_sub(2),
        }
    }

    /// Corners that are left over.
    pub(crate) fn unused_of(self, corners: usize) -> usize {
        match self {
            Self::List => corners % 3,
            Self::Strip | Self::Fan if corners < 3 => corners,
            Self::Strip | Self::Fan => 0,
        }
    }

    /// The triangles of `count` corners, `corner(i)` being the vertex of the i-th; glTF 2.0 section
    /// 3.7.2.1.
    ///
    /// Strips and fans drop triangles that name a vertex twice: they stitch parts together and have
    /// no area.
    pub(crate) fn triangles(self, count: usize, corner: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
        let n = self.triangles_of(count);
        let whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        match self {
            Self::List => (0..n).map(|i| [corner(3 * i), corner(3 * i + 1), corner(3 * i + 2)]).collect(),
            // Every other triangle of a strip turns round, so that all face one way.
            Self::Strip => {
                (0..n).map(|i| [corner(i), corner(i + 1 + i % 2), corner(i + 2 - i % 2)]).filter(whole).collect()
            }
            Self::Fan => (0..n).map(|i| [corner(i + 1), corner(i + 2), corner(0)]).filter(whole).collect(),
        }
    }
}
