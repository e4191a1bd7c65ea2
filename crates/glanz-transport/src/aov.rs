//! Channels beside the picture itself.

use std::fmt;

/// One kind of extra channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Aov {
    /// `Albedo.R/G/B`: fraction of light that the surface reflects or transmits.
    Albedo,
    /// `P.X/Y/Z`: world position, metres.
    Position,
    /// `N.X/Y/Z`: geometric normal.
    Normal,
    /// `Ns.X/Y/Z`: shading normal.
    ShadingNormal,
    /// `u`, `v`: texture coordinates.
    Uv,
    /// `Z`: distance along the ray, metres.
    Distance,
    /// `id`: number of the shape.
    Id,
    /// `Variance.R/G/B`: variance of the pixel's mean.
    Variance,
}

impl Aov {
    /// All AOVs, in the order of their channels.
    pub const ALL: [Self; 8] = [
        Self::Albedo,
        Self::Position,
        Self::Normal,
        Self::ShadingNormal,
        Self::Uv,
        Self::Distance,
        Self::Id,
        Self::Variance,
    ];

    /// Its name on the command line and in checkpoints: the name of its channels without the component.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Albedo => "Albedo",
            Self::Position => "P",
            Self::Normal => "N",
            Self::ShadingNormal => "Ns",
            Self::Uv => "uv",
            Self::Distance => "Z",
            Self::Id => "id",
            Self::Variance => "Variance",
        }
    }

    /// The kind of that name, in any case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|aov| aov.name().eq_ignore_ascii_case(name))
    }
}

/// A set of extra channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AovSet(u8);

impl AovSet {
    /// No extra channels.
    pub const NONE: Self = Self(0);
    /// Every extra channel.
    pub const ALL: Self = Self(0xff);

    /// This set and `aov`.
    #[must_use]
    pub const fn with(self, aov: Aov) -> Self {
        Self(self.0 | 1 << aov as u8)
    }

    /// This set and `other`.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether `aov` is in the set.
    #[must_use]
    pub const fn contains(self, aov: Aov) -> bool {
        self.0 >> aov as u8 & 1 == 1
    }

    /// Whether any channel needs the camera ray's first hit.
    #[must_use]
    pub const fn needs_first_hit(self) -> bool {
        self.0 & !Self::NONE.with(Aov::Variance).0 != 0
    }

    /// One bit per kind, in the order of [`Aov::ALL`].
    #[must_use]
    pub const fn to_bits(self) -> u8 {
        self.0
    }

    /// The set of [`AovSet::to_bits`].
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }
}

impl FromIterator<Aov> for AovSet {
    fn from_iter<I: IntoIterator<Item = Aov>>(aovs: I) -> Self {
        aovs.into_iter().fold(Self::NONE, Self::with)
    }
}

impl fmt::Display for AovSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = Aov::ALL.into_iter().filter(|&a| self.contains(a)).map(Aov::name).collect();
        f.write_str(if names.is_empty() { "none".to_owned() } else { names.join(",") }.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_in_any_case() {
        for aov in Aov::ALL {
            assert_eq!(Aov::from_name(aov.name()), Some(aov));
        }
        assert_eq!(Aov::from_name("albedo"), Some(Aov::Albedo));
        assert_eq!(Aov::from_name("depth"), None);
    }

    #[test]
    fn sets_contain_the_inserted_kinds() {
        let set: AovSet = [Aov::Normal, Aov::Id].into_iter().collect();
        assert!(set.contains(Aov::Normal) && set.contains(Aov::Id) && !set.contains(Aov::Variance));
        assert_eq!(set.to_string(), "N,id");
        assert_eq!(AovSet::ALL, Aov::ALL.into_iter().collect());
        assert!(!AovSet::NONE.with(Aov::Variance).needs_first_hit());
        assert!(set.needs_first_hit());
    }
}
