//! Values at the middles of texels.

use glanz_math::{DVec2, DVec3};

/// A function over the unit square, sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    size: [usize; 2],
    texels: Vec<DVec3>,
}

impl Texture {
    /// The values of `f` at the middles of `size[0]` x `size[1]` texels.
    pub fn from_function(size: [usize; 2], mut f: impl FnMut(DVec2) -> DVec3) -> Self {
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            let v = (y as f64 + 0.5) / size[1] as f64;
            texels.extend((0..size[0]).map(|x| f(DVec2::new((x as f64 + 0.5) / size[0] as f64, v))));
        }
        Self { size, texels }
    }

    /// From texels, rows of u one after the other from v = 0; `None` if there are not `size[0]` x `size[1]`.
    #[must_use]
    pub fn from_texels(size: [usize; 2], texels: Vec<DVec3>) -> Option<Self> {
        (size[0].checked_mul(size[1]) == Some(texels.len())).then_some(Self { size, texels })
    }

    /// Texels along u and v.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// All texels, rows of u one after the other from v = 0.
    #[must_use]
    pub fn texels(&self) -> &[DVec3] {
        &self.texels
    }
}
