//! What a person or a program wrote about a device, before anybody knows whether it is right.

/// A value as it is written on the command line, in TOML or in JSON.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Given {
    /// `true`, `false`, or a word of the command line that stands alone.
    Flag(bool),
    /// A number.
    Number(f64),
    /// Text, also a number on the command line.
    Text(String),
    /// Several.
    List(Vec<Self>),
    /// Keys and values, in the order in which they were given.
    Table(Vec<(String, Self)>),
}

#[cfg(feature = "serde")]
mod of_serde {
    use core::fmt;

    use serde::de::{Error, MapAccess, SeqAccess, Visitor};
    use serde::{Deserialize, Deserializer};

    use super::Given;

    impl<'de> Deserialize<'de> for Given {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(Any)
        }
    }

    struct Any;

    #[expect(clippy::cast_precision_loss, reason = "no setting has more than 32 bits")]
    impl<'de> Visitor<'de> for Any {
        type Value = Given;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("true or false, a number, text, a list or a table")
        }

        fn visit_bool<E: Error>(self, on: bool) -> Result<Given, E> {
            Ok(Given::Flag(on))
        }

        fn visit_i64<E: Error>(self, number: i64) -> Result<Given, E> {
            Ok(Given::Number(number as f64))
        }

        fn visit_u64<E: Error>(self, number: u64) -> Result<Given, E> {
            Ok(Given::Number(number as f64))
        }

        fn visit_f64<E: Error>(self, number: f64) -> Result<Given, E> {
            Ok(Given::Number(number))
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Given, E> {
            Ok(Given::Text(text.to_owned()))
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Given, A::Error> {
            let mut all = Vec::new();
            while let Some(one) = list.next_element()? {
                all.push(one);
            }
            Ok(Given::List(all))
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Given, A::Error> {
            let mut all = Vec::new();
            while let Some(entry) = map.next_entry::<String, Given>()? {
                all.push(entry);
            }
            Ok(Given::Table(all))
        }
    }
}
