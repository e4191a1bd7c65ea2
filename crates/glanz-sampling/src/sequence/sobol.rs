//! The first four dimensions of the Sobol' sequence.

/// Number of dimensions.
pub const DIMENSIONS: usize = 4;

/// For each dimension after the first: degree and inner coefficients of its primitive polynomial, initial numbers.
///
/// # Source
/// @joe2008, file new-joe-kuo-6.
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// Generator matrices by columns, most significant bit of the coordinate first.
const DIRECTIONS: [[u32; 32]; DIMENSIONS] = directions();

/// Contribution of each byte of a *bit-reversed* index to the *bit-reversed* coordinates: `REVERSED[position][byte][dimension]`.
static REVERSED: [[[u32; DIMENSIONS]; 256]; 4] = reversed_by_byte();

const fn directions() -> [[u32; 32]; DIMENSIONS] {
    let mut all = [[0; 32]; DIMENSIONS];
    let mut i = 0;
    while i < 32 {
        all[0][i] = 1 << (31 - i);
        i += 1;
    }
    let mut d = 1;
    while d < DIMENSIONS {
        let (degree, coefficients, initial) = POLYNOMIALS[d - 1];
        let mut i = 0;
        while i < 32 {
            all[d][i] = if i < degree {
                initial[i] << (31 - i)
            } else {
                let mut v = all[d][i - degree] ^ (all[d][i - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    if coefficients >> (degree - 1 - k) & 1 == 1 {
                        v ^= all[d][i - k];
                    }
                    k += 1;
                }
                v
            };
            i += 1;
        }
        d += 1;
    }
    all
}

const fn reversed_by_byte() -> [[[u32; DIMENSIONS]; 256]; 4] {
    let mut tables = [[[0; DIMENSIONS]; 256]; 4];
    let mut position = 0;
    while position < 4 {
        let mut byte = 0;
        while byte < 256 {
            let mut d = 0;
            while d < DIMENSIONS {
                let mut bit = 0;
                while bit < 8 {
                    if byte >> bit & 1 == 1 {
                        tables[position][byte][d] ^= DIRECTIONS[d][31 - (8 * position + bit)].reverse_bits();
                    }
                    bit += 1;
                }
                d += 1;
            }
            byte += 1;
        }
        position += 1;
    }
    tables
}

/// The bit-reversed coordinate `dimension` (0 to 3, taken modulo 4), in units of 2^-32, of the point whose
/// bit-reversed index is `reversed_index`.
///
/// [`super::owen::scramble_reversed`] uses the reversed order, and reversing 32 bits costs more than scrambling them.
#[inline]
#[must_use]
pub fn coordinate_reversed(reversed_index: u32, dimension: usize) -> u32 {
    point_reversed(reversed_index)[dimension % DIMENSIONS]
}

/// All bit-reversed coordinates: those of [`coordinate_reversed`].
#[inline]
#[must_use]
pub fn point_reversed(reversed_index: u32) -> [u32; DIMENSIONS] {
    let [a, b, c, d] = reversed_index.to_le_bytes().map(usize::from);
    let [t0, t1, t2, t3] = &REVERSED;
    let ([x0, y0, z0, w0], [x1, y1, z1, w1]) = (t0[a], t1[b]);
    let ([x2, y2, z2, w2], [x3, y3, z3, w3]) = (t2[c], t3[d]);
    [x0 ^ x1 ^ x2 ^ x3, y0 ^ y1 ^ y2 ^ y3, z0 ^ z1 ^ z2 ^ z3, w0 ^ w1 ^ w2 ^ w3]
}

/// Coordinate `dimension` (0 to 3, taken modulo 4) of point `index`, in units of 2^-32.
///
/// Dimensions 0 and 1 together are a (0, 2)-sequence in base 2.
#[inline]
#[must_use]
pub fn coordinate(index: u32, dimension: usize) -> u32 {
    coordinate_reversed(index.reverse_bits(), dimension).reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_points_are_the_published_ones() {
        // @joe2008 in natural (not Gray code) order, units of 1/8.
        let expected: [[u32; 8]; 4] = [
            [0, 4, 2, 6, 1, 5, 3, 7],
            [0, 4, 6, 2, 5, 1, 3, 7],
            [0, 4, 6, 2, 3, 7, 5, 1],
            [0, 4, 6, 2, 1, 5, 7, 3],
        ];
        for (d, row) in expected.iter().enumerate() {
            for (i, &x) in row.iter().enumerate() {
                assert_eq!(coordinate(i as u32, d) >> 29, x, "dimension {d}, point {i}");
            }
        }
    }

    #[test]
    fn coordinates_are_sums_of_directions() {
        for i in (0..500).map(|i| crate::hash::combine(7, i) as u32) {
            for (d, directions) in DIRECTIONS.iter().enumerate() {
                let used = directions.iter().enumerate().filter(|&(bit, _)| i >> bit & 1 == 1);
                assert_eq!(coordinate(i, d), used.fold(0, |sum, (_, v)| sum ^ v), "dimension {d}, point {i}");
            }
        }
    }

    #[test]
    fn second_dimension_is_the_pascal_matrix_modulo_two() {
        // Binomial (j, i) is odd where i's bits are a subset of j's (Lucas).
        for j in 0..32_u32 {
            for i in 0..32 {
                let odd = i & j == i;
                assert_eq!(DIRECTIONS[1][j as usize] >> (31 - i) & 1 == 1, odd, "row {i}, column {j}");
            }
        }
    }

    #[test]
    fn every_dimension_visits_each_dyadic_interval_once() {
        for d in 0..DIMENSIONS {
            let mut seen = vec![false; 1024];
            for i in 0..1024 {
                seen[(coordinate(i, d) >> 22) as usize] = true;
            }
            assert!(seen.iter().all(|&s| s));
        }
    }
}
