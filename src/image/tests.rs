use super::*;

fn named(product: &str, content: &[u8]) -> Vec<u8> {
    let mut octets = [0xA5; 64];
    let mut writer = Writer::named(&mut octets, product);
    writer.put(content);
    let len = writer.finish().unwrap();
    Vec::from(&octets[..len])
}

#[test]
fn the_checksum_is_that_of_zlib() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
}

#[test]
fn the_byte_map_octet_for_octet() {
    let image = named("ap10", &[1, 2, 3]);
    assert_eq!(image[..22], *b"PROFIDRV\0\x03\0\0\0\x1A\x04ap10\x01\x02\x03");
    assert_eq!(image[22..], crc32(&image[..22]).to_be_bytes());
}

#[test]
fn an_image_of_another_product_is_refused_by_name() {
    let image = named("asda-a2", &[]);
    assert_eq!(open(&image).unwrap().of("asda-a2"), Ok(&[][..]));
    let error = open(&image).unwrap().of("ap10").unwrap_err();
    assert_eq!(error.to_string(), "it is of another device: asda-a2, expected ap10");
}

#[test]
fn every_prefix_and_every_single_bit_error_is_refused() {
    let image = named("ap10", &[1, 2, 3]);
    for len in 0..image.len() {
        assert!(open(&image[..len]).is_err(), "{len} octets");
    }
    for bit in 0..8 * image.len() {
        let mut damaged = image.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(open(&damaged).is_err(), "bit {bit}");
    }
}

#[test]
fn a_buffer_that_is_too_short_is_said() {
    let whole = named("ap10", &[1, 2, 3]).len();
    for room in 0..whole {
        let mut octets = Vec::from([0; 64]);
        let mut writer = Writer::named(&mut octets[..room], "ap10");
        writer.put(&[1, 2, 3]);
        assert_eq!(writer.finish(), Err(ImageError::NoRoom { got: room }));
    }
}

#[test]
fn a_newer_image_on_its_way_decides() {
    let mut newest = storage::Newest::SAFE;
    newest.offer();
    let first = newest.take().unwrap();
    newest.wait();
    newest.offer();
    newest.wait();
    let second = newest.take().unwrap();
    assert_eq!(newest.report(first, Err(NotStored)), storage::Outcome::None);
    assert_eq!(newest.report(first, Ok(())), storage::Outcome::None);
    assert_eq!(newest.report(second, Err(NotStored)), storage::Outcome::Undone);
    assert_eq!(newest.take(), None, "the host is not flooded");
    assert!(newest.wait_until_safe(), "a write offers it again");
    let third = newest.take().unwrap();
    assert_eq!(newest.report(third, Ok(())), storage::Outcome::Safe);
    assert!(!newest.wait_until_safe());
}
