//! The frame check sequence FCS (`dp-v0.md` 2): a sum over all octets from DA to the last data octet.
//!
//! Most of the time of a telegram goes into it, so that it is taken in blocks: arrays of a fixed length, which compilers
//! turn into vector instructions where there are any, without a loop for the octets left over.

/// The sum of the octets modulo 256. The last block need not begin where another ends: what was in one before is
/// taken out of it.
#[inline(always)]
pub(super) fn fcs_of(octets: &[u8]) -> u8 {
    if let Some((first, rest)) = octets.split_first_chunk::<BLOCK>() {
        // Two sums side by side: one alone waits for itself in each block.
        let (pairs, rest) = rest.as_chunks::<{ 2 * BLOCK }>();
        let (mut lanes, mut others) = (*first, [0; BLOCK]);
        for pair in pairs {
            if let ([one, other], []) = pair.as_chunks::<BLOCK>() {
                lanes = add(lanes, one);
                others = add(others, other);
            }
        }
        let (block, odd) = rest.as_chunks::<BLOCK>();
        let lanes = block.iter().fold(add(lanes, &others), add);
        sum(&add(lanes, &last_of(octets, odd.len())))
    } else if let (Some(first), Some(last)) = (octets.first_chunk(), octets.last_chunk()) {
        let odd = octets.len() - 8;
        sum_of_lanes(
            lanes_of(*first) + lanes_of((u64::from_le_bytes(*last) >> (56 - 8 * odd) >> 8).to_le_bytes()),
        )
    } else if let (Some(first), Some(last)) = (octets.first_chunk(), octets.last_chunk()) {
        let odd = octets.len() - 4;
        let odd = u64::from(u32::from_le_bytes(*last)) >> (32 - 8 * odd);
        sum_of_lanes(lanes_of((u64::from(u32::from_le_bytes(*first)) | odd << 32).to_le_bytes()))
    } else {
        sum(octets)
    }
}

/// Copies octets to where they just fit, and returns their sum as [`fcs_of`]. In blocks too, which for telegrams is
/// quicker than to call for a copy of any length: the last one is copied even where it overlaps the one before.
#[inline(always)]
pub(super) fn copy_summed(to: &mut [u8], from: &[u8]) -> u8 {
    let (blocks, odd) = from.as_chunks::<BLOCK>();
    if let (Some(last), [_, ..]) = (from.last_chunk::<BLOCK>(), blocks) {
        let mut lanes = [0; BLOCK];
        for (to, from) in to.as_chunks_mut::<BLOCK>().0.iter_mut().zip(blocks) {
            *to = *from;
            lanes = add(lanes, from);
        }
        if let Some(to) = to.last_chunk_mut() {
            *to = *last;
        }
        return sum(&add(lanes, &last_of(from, odd.len())));
    }
    if !copy_ends::<8>(to, from) && !copy_ends::<4>(to, from) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }
    fcs_of(from)
}

/// Copies the first `N` and the last `N` octets of at most twice as many, if there are so many.
#[inline(always)]
fn copy_ends<const N: usize>(to: &mut [u8], from: &[u8]) -> bool {
    let (Some(first), Some(last)) = (from.first_chunk::<N>(), from.last_chunk::<N>()) else { return false };
    if let Some(to) = to.first_chunk_mut() {
        *to = *first;
    }
    if let Some(to) = to.last_chunk_mut() {
        *to = *last;
    }
    true
}

/// Octets summed at once: what compilers make one vector instruction of.
const BLOCK: usize = 16;

#[inline(always)]
fn sum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum, octet| sum.wrapping_add(*octet))
}

/// Adds each octet to the one in its place.
#[inline(always)]
fn add(mut lanes: [u8; BLOCK], octets: &[u8; BLOCK]) -> [u8; BLOCK] {
    lanes.iter_mut().zip(octets).for_each(|(lane, octet)| *lane = lane.wrapping_add(*octet));
    lanes
}

/// The last `odd` octets behind zeros.
#[inline(always)]
fn last_of(octets: &[u8], odd: usize) -> [u8; BLOCK] {
    const MASKS: [u8; 2 * BLOCK] = {
        let mut masks = [0; 2 * BLOCK];
        masks.split_at_mut(BLOCK).1.copy_from_slice(&[0xFF; BLOCK]);
        masks
    };
    let masks = MASKS.get(odd..).and_then(|masks| masks.first_chunk::<BLOCK>());
    let (Some(last), Some(masks)) = (octets.last_chunk::<BLOCK>(), masks) else { return [0; BLOCK] };
    let mut last = *last;
    last.iter_mut().zip(masks).for_each(|(octet, mask)| *octet &= mask);
    last
}

/// Eight octets, added in pairs: four lanes of 16 bits.
#[inline(always)]
fn lanes_of(octets: [u8; 8]) -> u64 {
    const LANES: u64 = 0x00FF_00FF_00FF_00FF;
    let octets = u64::from_le_bytes(octets);
    (octets & LANES) + (octets >> 8 & LANES)
}

/// The product gathers the sum of all lanes in the highest one.
#[inline(always)]
fn sum_of_lanes(lanes: u64) -> u8 {
    let [.., sum, _] = lanes.wrapping_mul(0x0001_0001_0001_0001).to_le_bytes();
    sum
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn the_sum_of_any_number_of_octets_is_that_of_octet_by_octet() {
        let octets: Vec<u8> =
            (0..=300_u16).map(|number| u8::try_from(number * 37 % 251 + 5).unwrap()).collect();
        for from in 0..20 {
            for to in from..octets.len() {
                let counted = &octets[from..to];
                let expected = counted.iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
                assert_eq!(fcs_of(counted), expected, "octets {from}..{to}");
                let mut copy = std::vec![0; counted.len()];
                assert_eq!(copy_summed(&mut copy, counted), expected, "octets {from}..{to}");
                assert_eq!(copy, counted);
            }
        }
    }

    #[test]
    fn every_octet_counts_once_and_whole() {
        for len in 0..=249 {
            for at in 0..len {
                let mut octets = std::vec![0; len];
                octets[at] = 0xFF;
                assert_eq!(fcs_of(&octets), 0xFF, "octet {at} of {len}");
            }
        }
        assert_eq!(fcs_of(&[0xFF; 249]), 249_u8.wrapping_neg());
    }
}
