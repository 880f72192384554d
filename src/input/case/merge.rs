//! Merges trees of values: a value from a later source, such as an argument `--set`, replaces the value of the same
//! key from an earlier source, such as the case file.

use super::rules::alternatives;
use super::source::Origin;
use super::tree::{CaseNode, Entry, KeyPart, Value, child_place};

impl CaseNode {
    /// Merges the node `over` into this node, whose key path is `place`. Tables are merged key by key; other values of
    /// `over` replace those of this node. A new key removes old keys that must not be given together with it.
    pub fn overlay(&mut self, over: CaseNode, place: &str) {
        let (entries, over_entries) = match (&mut self.value, over.value) {
            (Value::Table(entries), Value::Table(over_entries)) => (entries, over_entries),
            (value, over_value) => {
                *value = over_value;
                self.origin = over.origin;
                return;
            }
        };
        let together: Vec<String> = over_entries.iter().map(|entry| entry.key.clone()).collect();
        for entry in over_entries {
            let rivals = alternatives(place, &entry.key);
            entries.retain(|old| {
                old.key == entry.key || together.contains(&old.key) || !rivals.contains(&old.key.as_str())
            });
            match entries.iter_mut().find(|old| old.key == entry.key) {
                Some(old) => {
                    let inner = child_place(place, &entry.key);
                    old.key_origin = entry.key_origin;
                    old.node.overlay(entry.node, &inner);
                }
                None => entries.push(entry),
            }
        }
    }

    /// Sets the value of the key at `path`. Tables on this path that do not exist yet are created.
    ///
    /// # Errors
    /// A message, if the path leads through a value that is not a table, or to an element that a list does not have.
    pub fn set(&mut self, path: &[KeyPart], value: CaseNode, key_origin: &Origin) -> Result<(), String> {
        self.set_at(path, value, key_origin, "", "")
    }

    /// Sets a value at `path` below this node. `place` is the key path of the node, with `[]` for any element of a
    /// list; it determines the keys that exclude each other. `walked` is the key path of the node as the user typed it,
    /// for messages.
    fn set_at(
        &mut self,
        path: &[KeyPart],
        value: CaseNode,
        key_origin: &Origin,
        place: &str,
        walked: &str,
    ) -> Result<(), String> {
        let Some((segment, rest)) = path.split_first() else {
            self.overlay(value, place);
            return Ok(());
        };
        let is_single = !matches!(self.value, Value::Table(_) | Value::Array(_));
        if let (true, KeyPart::Key(key)) = (is_single, segment)
            && !alternatives(place, key).is_empty()
        {
            // the table of a law replaces a number, or the name of another law
            *self = CaseNode::empty_table(key_origin.clone());
        }
        let kind = self.value.kind();
        match (&mut self.value, segment) {
            (Value::Array(items), segment) if segment.index().is_some() => {
                let count = items.len();
                let index = segment.index().unwrap_or(usize::MAX);
                let item = items.get_mut(index).ok_or_else(|| {
                    format!("`{walked}` has {count} element{}, counted from 0", if count == 1 { "" } else { "s" })
                })?;
                item.set_at(rest, value, key_origin, &format!("{place}[]"), &format!("{walked}[{index}]"))
            }
            (Value::Table(entries), KeyPart::Key(key)) => {
                let inner_place = child_place(place, key);
                let inner_walked = child_place(walked, key);
                if !entries.iter().any(|entry| entry.key == *key) {
                    if matches!(rest.first(), Some(KeyPart::Index(_))) {
                        return Err(format!("there is no list `{inner_walked}` in the case file itself"));
                    }
                    let rivals = alternatives(place, key);
                    entries.retain(|old| !rivals.contains(&old.key.as_str()));
                    let node = CaseNode::empty_table(key_origin.clone());
                    entries.push(Entry { key: key.clone(), key_origin: key_origin.clone(), node });
                }
                match entries.iter_mut().find(|entry| entry.key == *key) {
                    Some(entry) => {
                        if rest.is_empty() {
                            entry.key_origin = key_origin.clone();
                        }
                        entry.node.set_at(rest, value, key_origin, &inner_place, &inner_walked)
                    }
                    None => Err(format!("there is no `{inner_walked}`")),
                }
            }
            (_, KeyPart::Key(key)) => Err(format!("`{walked}` is {kind}, it has no key `{key}`")),
            (_, KeyPart::Index(index)) => Err(format!("`{walked}` is {kind}, it has no element {index}")),
        }
    }
}
