//! Any message, for proptest.
//!
//! Every message can be deserialised. [`Draw`] is a deserializer that answers whatever is asked for with a random value,
//! so it makes every variant of every message, without a list of them.

use std::fmt::Debug;

use hexsense_core::wire::telemetry::{Block, Header, MAX_SCANS};
use proptest::collection::vec;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::de::value::Error;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, SeqAccess,
    VariantAccess, Visitor,
};

/// Any value of this type.
pub fn message<T: DeserializeOwned + Debug>() -> impl Strategy<Value = T> {
    any::<u64>().prop_map(|seed| {
        let mut draw = Draw(ChaCha8Rng::seed_from_u64(seed));
        // A list or text that is drawn too long for its type is drawn again.
        let drawn = (0..100).find_map(|_| T::deserialize(&mut draw).ok());
        drawn.expect("most values fit their types")
    })
}

pub fn block() -> impl Strategy<Value = Block> {
    (message::<Header>(), 1..=MAX_SCANS as u8).prop_flat_map(|(header, scans)| {
        let counts = vec(any::<[u16; 15]>(), usize::from(scans));
        let values = vec(any::<[f32; 9]>(), usize::from(scans));
        (counts, values).prop_map(move |(counts, values)| Block {
            header: Header { scans, ..header },
            counts: (header.content.counts).then(|| counts.into_iter().collect()),
            values: (header.content.values).then(|| values.into_iter().collect()),
        })
    })
}

struct Draw(ChaCha8Rng);

impl Draw {
    /// As often short as long.
    fn length(&mut self) -> usize {
        let longest = 1 << self.0.random_range(0..8);
        self.0.random_range(0..=longest)
    }
}

/// Methods that draw a number of their type. Floats are finite, because NaN differs from itself: one bit of the exponent
/// is 0.
macro_rules! numbers {
    ($($method:ident $visit:ident $number:expr,)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            let number: fn(&mut ChaCha8Rng) -> _ = $number;
            visitor.$visit(number(&mut self.0))
        }
    )*};
}

impl<'de> Deserializer<'de> for &mut Draw {
    type Error = Error;

    numbers! {
        deserialize_bool visit_bool |random| random.random(),
        deserialize_u8 visit_u8 |random| random.random(),
        deserialize_u16 visit_u16 |random| random.random(),
        deserialize_u32 visit_u32 |random| random.random(),
        deserialize_u64 visit_u64 |random| random.random(),
        deserialize_i64 visit_i64 |random| random.random(),
        deserialize_f32 visit_f32 |random| f32::from_bits(random.random::<u32>() & !(1 << 23)),
        deserialize_f64 visit_f64 |random| f64::from_bits(random.random::<u64>() & !(1 << 52)),
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let text: String = (0..self.length())
            .map(|_| self.0.random::<char>())
            .collect();
        visitor.visit_str(&text)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        if self.0.random() {
            visitor.visit_some(self)
        } else {
            visitor.visit_none()
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let left = self.length();
        visitor.visit_seq(Items { draw: self, left })
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_seq(Items { draw: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(fields.len(), visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_enum(Variant {
            draw: self,
            variants: variants.len() as u32,
        })
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        unimplemented!("no message has such a field")
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 char string bytes byte_buf unit unit_struct tuple_struct map identifier ignored_any
    }
}

/// So many items of a list, or fields.
struct Items<'d> {
    draw: &'d mut Draw,
    left: usize,
}

impl<'de> SeqAccess<'de> for Items<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Error> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(&mut *self.draw).map(Some)
    }
}

/// One of so many variants.
struct Variant<'d> {
    draw: &'d mut Draw,
    variants: u32,
}

impl<'d, 'de> EnumAccess<'de> for Variant<'d> {
    type Error = Error;
    type Variant = &'d mut Draw;

    fn variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<(S::Value, Self::Variant), Error> {
        let index = self.draw.0.random_range(0..self.variants);
        Ok((seed.deserialize(index.into_deserializer())?, self.draw))
    }
}

impl<'de> VariantAccess<'de> for &mut Draw {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, fields: usize, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_tuple(fields, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(fields.len(), visitor)
    }
}
