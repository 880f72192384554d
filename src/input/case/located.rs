//! Values of a case, each with its position in the text of the case and its key path, such as `soft.hertz`.

use super::source::Origin;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer, Error as _, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Value of a case, with the source position and the key path that messages about the value contain.
#[derive(Clone, Debug)]
pub struct Located<T> {
    /// Value that was read from the case.
    pub value: T,
    /// Position of the value in its source text.
    pub origin: Origin,
    /// Path of the key, such as `particles[0].diameter`.
    pub path: String,
}

/// Name by which the deserializer (code that gives the values of a case to the types) recognises a [`Located`]. For
/// this name it gives the source position of a value and then the value.
pub(super) const LOCATED: &str = "$located";

/// Name under which [`Place`] asks the deserializer (code that gives the values of a case to the types) for its four
/// fields. It is the only type in a case that asks as a unit struct (a struct without fields).
const PLACE: &str = "$place";

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Located<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Readings<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Readings<T> {
            type Value = Located<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a value of a case")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Located<T>, A::Error> {
                match (seq.next_element::<Place>()?, seq.next_element::<T>()?) {
                    (Some(Place { origin, path }), Some(value)) => Ok(Located { value, origin, path }),
                    _ => Err(A::Error::custom("a value without a place")),
                }
            }
        }
        deserializer.deserialize_tuple_struct(LOCATED, 2, Readings(PhantomData))
    }
}

/// Source position and key path of a value, without the value.
pub(super) struct Place {
    origin: Origin,
    path: String,
}

impl<'de> Deserialize<'de> for Place {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Fields;
        impl<'de> Visitor<'de> for Fields {
            type Value = Place;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a place in a case")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Place, A::Error> {
                let missing = || A::Error::custom("a value without a place");
                let source = seq.next_element()?.ok_or_else(missing)?;
                let start = seq.next_element()?.ok_or_else(missing)?;
                let end = seq.next_element()?.ok_or_else(missing)?;
                let path = seq.next_element()?.ok_or_else(missing)?;
                Ok(Place { origin: Origin { source, span: start..end }, path })
            }
        }
        deserializer.deserialize_unit_struct(PLACE, Fields)
    }
}

impl<T: JsonSchema> JsonSchema for Located<T> {
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}
