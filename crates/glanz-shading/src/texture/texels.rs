//! Values of texels in memory.

use std::sync::Arc;

/// Number of values of a byte.
const BYTE_VALUES: usize = 256;

/// Places for the numbers of values while they are found: few collide.
const PLACES: usize = 4 * BYTE_VALUES;

/// The values of the bytes of each plane.
pub(super) type TexelPalette = Vec<[f32; BYTE_VALUES]>;

/// Texels in rows, with one value for grey or three for red, green and blue.
#[derive(Debug)]
pub(super) enum TexelValues {
    /// A byte for each value, as in most files; the values themselves are as exact as with [`TexelValues::Floats`].
    Bytes { bytes: Vec<u8>, palette: Arc<TexelPalette> },
    /// The values.
    Floats { values: Vec<f32>, planes: usize },
}

/// The form of texels in a file.
#[derive(Clone, Debug)]
pub(super) struct TexelFormat {
    /// Values of a texel: one or three.
    planes: usize,
    /// `None`: values are stored as floats.
    palette: Option<Arc<TexelPalette>>,
}

impl TexelFormat {
    /// Values of a texel: one or three.
    pub(super) fn planes(&self) -> usize {
        self.planes
    }

    /// Bytes of a texel.
    pub(super) fn texel_bytes(&self) -> usize {
        self.planes * if self.palette.is_some() { 1 } else { size_of::<f32>() }
    }

    /// Memory of the form itself, bytes.
    pub(super) fn memory(&self) -> u64 {
        self.palette.as_deref().map_or(0, palette_memory)
    }

    /// The texels that [`TexelValues::append`] wrote.
    pub(super) fn texels(&self, bytes: Vec<u8>) -> TexelValues {
        match &self.palette {
            Some(palette) => TexelValues::Bytes { bytes, palette: Arc::clone(palette) },
            None => {
                let values = bytes.as_chunks().0.iter().map(|value| f32::from_le_bytes(*value)).collect();
                TexelValues::Floats { values, planes: self.planes }
            }
        }
    }
}

impl TexelValues {
    /// The texels of planes, one for grey or three, of the same length; as bytes if no plane has more than 256 values, and if that takes less memory.
    pub(super) fn of_planes(planes: &[&[f32]]) -> Self {
        let planes = match planes {
            [red, green, blue] if is_same(red, green) && is_same(red, blue) => &planes[..1],
            _ => planes,
        };
        let is_worth = planes.iter().all(|plane| plane.len() > 2 * BYTE_VALUES);
        let found = planes.iter().map(|plane| numbered(plane).filter(|_| is_worth));
        match found.collect::<Option<Vec<_>>>() {
            Some(found) => {
                let (bytes, palette): (Vec<_>, Vec<_>) = found.into_iter().unzip();
                let bytes = interleaved(&bytes.iter().map(Vec::as_slice).collect::<Vec<_>>());
                Self::Bytes { bytes, palette: Arc::new(palette) }
            }
            None => Self::Floats { values: interleaved(planes), planes: planes.len() },
        }
    }

    /// Red, green and blue of a texel; black beyond the last one.
    #[inline]
    pub(super) fn texel(&self, index: usize) -> [f32; 3] {
        match self {
            Self::Bytes { bytes, palette } => match (&palette[..], bytes.as_chunks().0.get(index)) {
                ([red, green, blue], Some(&[r, g, b])) => {
                    [red[usize::from(r)], green[usize::from(g)], blue[usize::from(b)]]
                }
                ([grey], _) => bytes.get(index).map_or([0.0; 3], |&y| [grey[usize::from(y)]; 3]),
                _ => [0.0; 3],
            },
            Self::Floats { values, planes: 1 } => values.get(index).map_or([0.0; 3], |&y| [y; 3]),
            Self::Floats { values, .. } => values.as_chunks().0.get(index).copied().unwrap_or([0.0; 3]),
        }
    }

    /// Values of a texel: one or three.
    pub(super) fn planes(&self) -> usize {
        match self {
            Self::Bytes { palette, .. } => palette.len(),
            Self::Floats { planes, .. } => *planes,
        }
    }

    /// Memory of the values, bytes, with that of their palette.
    pub(super) fn memory(&self) -> u64 {
        match self {
            Self::Bytes { bytes, palette } => bytes.len() as u64 + palette_memory(palette),
            Self::Floats { values, .. } => size_of_val(&values[..]) as u64,
        }
    }

    pub(super) fn format(&self) -> TexelFormat {
        let palette = match self {
            Self::Bytes { palette, .. } => Some(Arc::clone(palette)),
            Self::Floats { .. } => None,
        };
        TexelFormat { planes: self.planes(), palette }
    }

    /// The same floats of rows of `length` texels in longer rows, with zeros behind.
    pub(super) fn with_row_length(self, length: usize, longer: usize) -> Self {
        match self {
            Self::Floats { values, planes } if length < longer => {
                let rows = values.chunks(planes * length);
                let with_zeros = |row: &[f32]| [row, &vec![0.0; planes * longer - row.len()]].concat();
                Self::Floats { values: rows.flat_map(with_zeros).collect(), planes }
            }
            other => other,
        }
    }

    /// Appends the texels of `range`, all of which must be there, in their form in a file.
    pub(super) fn append(&self, range: std::ops::Range<usize>, out: &mut Vec<u8>) {
        let planes = self.planes();
        let range = range.start * planes..range.end * planes;
        match self {
            Self::Bytes { bytes, .. } => out.extend_from_slice(bytes.get(range).unwrap_or_default()),
            Self::Floats { values, .. } => {
                let values = values.get(range).unwrap_or_default();
                out.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            }
        }
    }
}

fn palette_memory(palette: &TexelPalette) -> u64 {
    size_of_val(&palette[..]) as u64
}

/// Whether all bits are equal.
fn is_same(a: &[f32], b: &[f32]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// The values of the planes, texel after texel.
fn interleaved<T: Copy>(planes: &[&[T]]) -> Vec<T> {
    match planes {
        [a, b, c] => a.iter().zip(*b).zip(*c).flat_map(|((&a, &b), &c)| [a, b, c]).collect(),
        _ => planes.first().map_or_else(Vec::new, |plane| plane.to_vec()),
    }
}

/// The numbers of the values in a table of them; `None` if there are more than a byte can number.
fn numbered(values: &[f32]) -> Option<(Vec<u8>, [f32; BYTE_VALUES])> {
    let (mut table, mut count) = ([0.0_f32; BYTE_VALUES], 0_usize);
    let mut places = [None::<u8>; PLACES];
    let mut numbers = Vec::with_capacity(values.len());
    for &value in values {
        // Fibonacci hashing: the upper bits of a product.
        let mut place = (value.to_bits().wrapping_mul(0x9e37_79b9) >> 22) as usize % PLACES;
        let number = loop {
            match places[place] {
                Some(number) if table[usize::from(number)].to_bits() == value.to_bits() => break number,
                Some(_) => place = (place + 1) % PLACES,
                None => {
                    let number = u8::try_from(count).ok()?;
                    (table[count], places[place]) = (value, Some(number));
                    count += 1;
                    break number;
                }
            }
        };
        numbers.push(number);
    }
    Some((numbers, table))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texels(values: &TexelValues, count: usize) -> Vec<[f32; 3]> {
        (0..count).map(|i| values.texel(i)).collect()
    }

    #[test]
    fn values_are_bytes_if_there_are_few_and_floats_otherwise() {
        let few: Vec<f32> = (0..1000).map(|i| (i % 256) as f32 / 255.0).collect();
        let many: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        let mirrored: Vec<f32> = few.iter().map(|x| 1.0 - x).collect();
        for (planes, bytes) in [
            ([&few[..], &mirrored, &few], 3000 + 3 * 1024),
            ([&few, &few, &few], 1000 + 1024),
            ([&few, &many, &few], 12_000),
            ([&many, &many, &many], 4000),
        ] {
            let values = TexelValues::of_planes(&planes);
            assert_eq!(values.memory(), bytes);
            let expected: Vec<_> = (0..1000).map(|i| planes.map(|plane| plane[i])).collect();
            assert_eq!(texels(&values, 1000), expected);
            let mut file = Vec::new();
            values.append(10..20, &mut file);
            assert_eq!(file.len(), 10 * values.format().texel_bytes());
            assert_eq!(texels(&values.format().texels(file), 10), expected[10..20]);
            assert_eq!(values.texel(1000), [0.0; 3]);
        }
    }

    #[test]
    fn zeros_of_both_signs_and_values_that_are_not_finite_are_kept() {
        let plane = [0.0, -0.0, f32::INFINITY, f32::NAN, 0.0];
        // A palette would take more.
        assert_eq!(TexelValues::of_planes(&[&plane]).memory(), 20);
        let plane = plane.repeat(200);
        let values = TexelValues::of_planes(&[&plane]);
        assert_eq!(values.memory(), 1000 + 1024);
        for (i, value) in plane.iter().enumerate() {
            assert_eq!(values.texel(i).map(f32::to_bits), [value.to_bits(); 3]);
        }
    }
}
