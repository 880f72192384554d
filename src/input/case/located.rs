//! Values of a case with their source position and key path.

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

/// Name that [`Located`] passes to the deserializer as the name of a tuple struct. For a struct of this name the
/// deserializer returns the place of a value and then the value.
pub(super) const LOCATED: &str = "$located";

/// Name that [`Place`] passes to the deserializer as the name of a unit struct. `Place` is the only unit struct in a
/// case, and the deserializer returns its four fields.
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
