//! Functions sampled at the middles of texels.

use glanz_math::{DVec2, DVec3};

/// Values of a function over the unit square at the middles of texels.
#[derive(Clone, Debug, PartialEq)]
pub struct InterpolatedTexture {
    size: [usize; 2],
    texels: Vec<DVec3>,
}

impl InterpolatedTexture {
    /// The values of `f` at the middles of `size[0]` x `size[1]` texels.
    pub fn from_function(size: [usize; 2], mut f: impl FnMut(DVec2) -> DVec3) -> Self {
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            let v = (y as f64 + 0.5) / size[1] as f64;
            texels.extend((0..size[0]).map(|x| f(DVec2::new((x as f64 + 0.5) / size[0] as f64, v))));
        }
        Self { size, texels }
    }

    /// Texels by rows of constant v, from v = 0; `None` unless there are `size[0]` x `size[1]`.
    #[must_use]
    pub fn from_texels(size: [usize; 2], texels: Vec<DVec3>) -> Option<Self> {
        (size[0].checked_mul(size[1]) == Some(texels.len())).then_some(Self { size, texels })
    }

    /// Number of texels along u and v.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// All texels by rows of constant v, from v = 0.
    #[must_use]
    pub fn texels(&self) -> &[DVec3] {
        &self.texels
    }
}
