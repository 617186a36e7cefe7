//! Images of nodes on disk: what earlier versions wrote, and whose they are.

use std::fs;

use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::host::StateDir;
use profidrive::host::can::{Product, StoredNode};
use profidrive::host::list::Choices;
use profidrive::time::Instant;

/// An image that the version before images named their product has written.
struct Golden {
    product: &'static str,
    node: u8,
    image: &'static [u8],
    values: &'static [(Address, u32)],
}

const GOLDEN: &[Golden] = &[
    Golden {
        product: "ag03-1",
        node: 5,
        image: include_bytes!("golden/ag03-1-node-005.eeprom"),
        values: &[
            (Address::new(0x2410, 5), 77),
            (Address::new(0x1800, 5), 250),
            (Address::new(0x2100, 0), 9),
        ],
    },
    Golden {
        product: "ap10",
        node: 6,
        image: include_bytes!("golden/ap10-node-006.eeprom"),
        values: &[(Address::new(0x5F10, 0), 77), (Address::new(0x1017, 0), 300)],
    },
    Golden {
        product: "asda-a2",
        node: 7,
        image: include_bytes!("golden/asda-a2-node-007.eeprom"),
        values: &[(Address::new(0x6081, 0), 12_345), (Address::new(0x1017, 0), 300)],
    },
];

fn load(state: &StateDir, product: &str, node: u8) -> Result<StoredNode, String> {
    let product = Product::named(product).unwrap();
    let node = NodeId::new(node).unwrap();
    let loaded = state.load_node(product, node, &Choices::default(), Instant::ZERO);
    loaded.map_err(|error| error.to_string())
}

fn value(node: &StoredNode, at: Address) -> u32 {
    let device = node.as_device();
    let octets = device.node().read_with(at, device.application(), |octets| Ok(octets.to_vec())).unwrap();
    octets.iter().rev().fold(0, |value, octet| value << 8 | u32::from(*octet))
}

#[test]
fn images_without_a_product_are_loaded_and_written_anew_with_it() {
    let folder = tempfile::tempdir().unwrap();
    for Golden { product, node, image, values } in GOLDEN {
        let file = folder.path().join(format!("{product}-node-{node:03}.eeprom"));
        fs::write(&file, image).unwrap();
        for start in ["as it was", "written anew"] {
            let state = StateDir::open(folder.path()).unwrap();
            let mut loaded = load(&state, product, *node).unwrap();
            for (at, expected) in *values {
                assert_eq!(value(&loaded, *at), *expected, "{product} {at} {start}");
            }
            loaded.act(Instant::ZERO, |device, now| {
                let save = device.write_without_bus(now, Address::new(0x1010, 1), b"save");
                let rate = device.write_without_bus(now, Address::new(0x2100, 0), &[9]);
                assert!(save.is_ok() || rate.is_ok(), "{product}");
            });
        }
        let name = if *product == "ag03-1" { "PROFIDRV" } else { product };
        let written = fs::read(&file).unwrap();
        assert!(written.windows(name.len()).any(|octets| octets == name.as_bytes()), "{product}");
    }
}

#[test]
fn an_image_of_another_product_is_refused_by_name_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let file = |product: &str| folder.path().join(format!("{product}-node-007.eeprom"));
    for product in ["ap10", "asda-a2"] {
        let state = StateDir::open(folder.path()).unwrap();
        let mut node = load(&state, product, 7).unwrap();
        node.act(Instant::ZERO, |device, now| {
            device.write_without_bus(now, Address::new(0x1010, 1), b"save").unwrap();
        });
    }
    let images = ["ap10", "asda-a2"].map(|product| fs::read(file(product)).unwrap());
    let [ap10, asda] = &images;
    for (product, other, image) in [("ap10", "asda-a2", asda), ("asda-a2", "ap10", ap10)] {
        fs::write(file(product), image).unwrap();
        let state = StateDir::open(folder.path()).unwrap();
        let error = load(&state, product, 7).err().unwrap();
        assert!(error.contains(&format!("it is of another device: {other}, expected {product}")), "{error}");
        assert_eq!(fs::read(file(product)).unwrap(), *image);
    }
    // Those without a product are told apart by their objects.
    for (product, image) in [("ap10", GOLDEN[2].image), ("asda-a2", GOLDEN[1].image)] {
        fs::write(file(product), image).unwrap();
        let state = StateDir::open(folder.path()).unwrap();
        let error = load(&state, product, 7).err().unwrap();
        assert!(
            error
                .contains(&format!("it is of another device: a node with other objects, expected {product}"))
        );
    }
    fs::write(file("ag03-1"), &images[0]).unwrap();
    let state = StateDir::open(folder.path()).unwrap();
    let error = load(&state, "ag03-1", 7).err().unwrap();
    assert!(error.contains("it is of another device: ap10, expected AG03/1"), "{error}");
}
