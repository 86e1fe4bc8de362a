//! `extras`: what glTF has no words for, in an object named `ontile`.

use std::collections::BTreeMap;

use gltf::json;
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use super::document::Document;
use crate::{Error, Result};

/// What may be said of nodes, of those with lights in part: [`super::light`], [`super::around`],
/// [`super::environment`], [`super::decal`], [`super::particles`].
pub const OF_NODES: [&str; 12] = [
    "shadow",
    "dynamic",
    "priority",
    "back_color",
    "ground_color",
    "box",
    "globe_map",
    "baked",
    "lightmap",
    "probe",
    "decal",
    "particles",
];

/// What may be said of scenes (`scenes[i].extras.ontile`): [`super::environment`], [`super::around`].
pub const OF_SCENES: [&str; 4] = ["environment", "background", "fog", "lightmap"];

/// Whether there is anything for this program in these.
pub fn is_ours(extras: &json::Extras) -> bool {
    ours(extras).is_some()
}

/// The member `ontile` as it is written. What else is there is nobody's business, also where it is JSON that no [`Value`] can hold.
fn ours(extras: &json::Extras) -> Option<Box<RawValue>> {
    let all: Option<BTreeMap<String, Box<RawValue>>> =
        extras.as_deref().and_then(|raw| serde_json::from_str(raw.get()).ok());
    all?.remove("ontile")
}

/// The members of an object that are known to be meant for this program.
pub struct Extras<'a> {
    members: BTreeMap<String, Extra<'a>>,
}

/// A value, and the place in the file that messages name.
pub struct Extra<'a> {
    doc: &'a Document<'a>,
    element: String,
    value: Value,
}

impl<'a> Extras<'a> {
    /// The members of `ontile` in the extras of these elements, each with its path; later elements win. Extras may be
    /// anything, so what is no object, or has no `ontile`, counts as empty.
    ///
    /// # Errors
    /// [`Error::Input`] if `ontile` is no object, has members that are not in `known`, or numbers that f64 cannot hold.
    pub fn read(doc: &'a Document, elements: &[(&json::Extras, String)], known: &[&str]) -> Result<Self> {
        let mut members = BTreeMap::new();
        for (extras, element) in elements {
            let Some(raw) = ours(extras) else { continue };
            let element = format!("{element}.extras.ontile");
            let value = serde_json::from_str(raw.get()).map_err(|e| {
                let problem = format!("cannot be parsed: {e} of it");
                doc.bad(&element, problem, "correct the value there, or remove it")
            })?;
            members.extend(Extra { doc, element, value }.object(known)?.members);
        }
        Ok(Self { members })
    }

    /// The member of this name.
    pub fn get(&self, name: &str) -> Option<&Extra<'a>> {
        self.members.get(name)
    }

    /// The same, for itself.
    pub fn take(mut self, name: &str) -> Option<Extra<'a>> {
        self.members.remove(name)
    }

    /// The member of this name as a number that `holds`, as `rule` says; `default` without it.
    pub fn number_or(&self, name: &str, default: f32, rule: &str, holds: fn(f32) -> bool) -> Result<f32> {
        self.get(name).map_or(Ok(default), |extra| extra.number(rule, holds))
    }
}

impl<'a> Extra<'a> {
    /// An [`Error::Input`] about this value.
    pub fn bad(&self, problem: impl Into<String>, remedy: impl Into<String>) -> Error {
        self.doc.bad(&self.element, problem, remedy)
    }

    /// The file it is in.
    pub fn doc(&self) -> &'a Document<'a> {
        self.doc
    }

    fn must_be(&self, what: &str) -> Error {
        self.bad(format!("is {}, but must be {what}", self.value), "correct the value, or remove it")
    }

    pub fn object(&self, known: &[&str]) -> Result<Extras<'a>> {
        let Value::Object(values) = &self.value else { return Err(self.must_be("an object")) };
        self.members(values, known)
    }

    fn members(&self, values: &Map<String, Value>, known: &[&str]) -> Result<Extras<'a>> {
        let member = |(name, value): (&String, &Value)| {
            let element = format!("{}.{name}", self.element);
            let extra = Extra { doc: self.doc, element, value: value.clone() };
            if known.contains(&name.as_str()) {
                return Ok((name.clone(), extra));
            }
            Err(extra.bad("is not a name that is known here", format!("use one of: {}", known.join(", "))))
        };
        Ok(Extras { members: values.iter().map(member).collect::<Result<_>>()? })
    }

    pub fn text(&self) -> Result<&str> {
        self.value.as_str().ok_or_else(|| self.must_be("a text"))
    }

    pub fn bool(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.must_be("true or false"))
    }

    /// `None` if it is no switch, but something else.
    pub fn as_bool(&self) -> Option<bool> {
        self.value.as_bool()
    }

    pub fn number(&self, rule: &str, holds: fn(f32) -> bool) -> Result<f32> {
        let number = self.value.as_f64().map(|v| v as f32).filter(|&v| v.is_finite() && holds(v));
        number.ok_or_else(|| self.must_be(&format!("a number{rule}")))
    }

    /// Exactly N numbers.
    pub fn numbers<const N: usize>(&self, rule: &str, holds: fn(f32) -> bool) -> Result<[f32; N]> {
        let number = |v: &Value| v.as_f64().map(|v| v as f32).filter(|&v| v.is_finite() && holds(v));
        let numbers =
            self.value.as_array().and_then(|list| list.iter().map(number).collect::<Option<Vec<_>>>());
        let numbers = numbers.and_then(|list| list.try_into().ok());
        numbers.ok_or_else(|| self.must_be(&format!("a list of {N} numbers{rule}")))
    }

    pub fn index<T>(&self) -> Result<json::Index<T>> {
        let index = self.value.as_u64().and_then(|v| u32::try_from(v).ok());
        index.map(json::Index::new).ok_or_else(|| self.must_be("an index"))
    }

    /// Exactly N indices, each with the path of its element.
    pub fn indices<T, const N: usize>(&self) -> Result<[(json::Index<T>, String); N]> {
        let index = |(i, v): (usize, &Value)| {
            let index = v.as_u64().and_then(|v| u32::try_from(v).ok())?;
            Some((json::Index::new(index), format!("{}[{i}]", self.element)))
        };
        let indices = self
            .value
            .as_array()
            .and_then(|list| list.iter().enumerate().map(index).collect::<Option<Vec<_>>>());
        let indices = indices.and_then(|list| list.try_into().ok());
        indices.ok_or_else(|| self.must_be(&format!("a list of {N} indices")))
    }

    /// Its path in the file.
    pub fn element(&self) -> &str {
        &self.element
    }
}
