//! Owen-scrambled Sobol points: the first four dimensions, 2^16 points.
//!
//! The same numbers as `sobol_burley::sample_4d` in dimension set 0, bit for bit. Its loop over the set bits of the index
//! mispredicts about every second time; here four look-ups, one per four bits, are combined without a branch.

use sobol_burley::parts::{Int4, hash, hash_int4, owen_scramble_int4_rev, owen_scramble_rev};

/// Points before the sequence repeats.
pub const LENGTH_LOG2: u32 = 16;

/// Four bits of the reversed index select a row, from the highest four on: the exclusive or of their direction vectors, whose
/// bits are reversed too.
static ROWS: [[[u32; 4]; 16]; 4] = rows();

/// A point of a sequence of its own per seed, shuffled and scrambled; the index comes with its bits reversed. Burley 2020,
/// "Practical Hash-based Owen Scrambling"; constants as in `sobol_burley`.
#[inline]
pub fn owen_sobol_4d(index_rev: u32, seed: u32) -> [f32; 4] {
    let shuffled = owen_scramble_rev(index_rev, hash(seed ^ 0x79c6_8e4a));
    let row = |group: usize| Int4::from(ROWS[group][(shuffled >> (28 - 4 * group)) as usize & 15]);
    let point = (row(0) ^ row(1)) ^ (row(2) ^ row(3));
    let seeds = Int4::from([seed.wrapping_mul(0x9c8f_2d3b); 4]);
    let scramble = seeds ^ Int4::from([0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8]);
    owen_scramble_int4_rev(point, hash_int4(scramble)).reverse_bits().to_f32_norm()
}

const fn rows() -> [[[u32; 4]; 16]; 4] {
    let mut rows = [[[0; 4]; 16]; 4];
    let mut group = 0;
    while group < 4 {
        let mut bits = 0;
        while bits < 16 {
            let mut bit = 0;
            while bit < 4 {
                if bits >> (3 - bit) & 1 == 1 {
                    let direction = direction(4 * group + bit);
                    let mut dimension = 0;
                    while dimension < 4 {
                        rows[group][bits][dimension] ^= direction[dimension];
                        dimension += 1;
                    }
                }
                bit += 1;
            }
            bits += 1;
        }
        group += 1;
    }
    rows
}

/// The direction vectors that bit `bit` of the index adds, bits reversed. Primitive polynomials 1, x + 1, x^2 + x + 1 and
/// x^3 + x + 1 with the initial numbers of Joe & Kuo 2008 (new-joe-kuo-6): 1; 1, 3; 1, 3, 1.
const fn direction(bit: usize) -> [u32; 4] {
    let mut m = [[0u32; 4]; LENGTH_LOG2 as usize];
    let mut k = 0;
    while k <= bit {
        m[k][0] = 1;
        m[k][1] = if k < 1 { 1 } else { m[k - 1][1] ^ m[k - 1][1] << 1 };
        m[k][2] = if k < 2 { [1, 3][k] } else { m[k - 2][2] ^ m[k - 1][2] << 1 ^ m[k - 2][2] << 2 };
        m[k][3] = if k < 3 { [1, 3, 1][k] } else { m[k - 3][3] ^ m[k - 2][3] << 2 ^ m[k - 3][3] << 3 };
        k += 1;
    }
    // m_k / 2^k as a binary fraction: its bits from the top, reversed from the bottom.
    let mut vectors = m[bit];
    let mut dimension = 0;
    while dimension < 4 {
        vectors[dimension] = (vectors[dimension] << (31 - bit)).reverse_bits();
        dimension += 1;
    }
    vectors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_sobol_burley() {
        for index in (0..1u32 << LENGTH_LOG2).step_by(7) {
            let seed = index.wrapping_mul(0x9e37_79b9) ^ 5;
            assert_eq!(owen_sobol_4d(index.reverse_bits(), seed), sobol_burley::sample_4d(index, 0, seed), "{index}");
        }
    }
}
