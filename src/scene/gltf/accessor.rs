//! Typed data out of accessors, every byte range checked before it is read.

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::{self, Index};

use super::document::{Document, MAX_VERTICES};
use crate::Result;

/// An accessor without a buffer view is all zeros and costs no bytes in the file; this many elements at most
/// are believed.
const MAX_UNBACKED_COUNT: u64 = 1 << 22;

/// What an attribute's accessor may look like (glTF 2.0 section 3.7.2.1).
#[derive(Clone, Copy)]
pub struct Format {
    types: &'static [Type],
    components: Components,
    /// For messages.
    text: &'static str,
}

#[derive(Clone, Copy, PartialEq)]
enum Components {
    #[cfg(feature = "measure")]
    Any,
    Float,
    /// With KHR_mesh_quantization also bytes and shorts of any kind.
    FloatOrQuantized,
    FloatOrNormalized,
    /// With signs too.
    FloatOrNormalizedAny,
    /// Both of the above.
    FloatNormalizedOrQuantized,
    Unsigned8Or16,
    Unsigned,
}

impl Format {
    pub const SCALAR: Self =
        Self { types: &[Type::Scalar], components: Components::Float, text: "a float SCALAR" };
    pub const VEC3: Self =
        Self { types: &[Type::Vec3], components: Components::FloatOrQuantized, text: "a float VEC3" };
    pub const VEC4: Self =
        Self { types: &[Type::Vec4], components: Components::FloatOrQuantized, text: "a float VEC4" };
    pub const MAT4: Self = Self { types: &[Type::Mat4], components: Components::Float, text: "a float MAT4" };
    pub const TEXCOORD: Self = Self {
        types: &[Type::Vec2],
        components: Components::FloatNormalizedOrQuantized,
        text: "a VEC2 of floats or normalised unsigned bytes or shorts",
    };
    pub const COLOR: Self = Self {
        types: &[Type::Vec3, Type::Vec4],
        components: Components::FloatOrNormalized,
        text: "a VEC3 or VEC4 of floats or normalised unsigned bytes or shorts",
    };
    pub const WEIGHTS: Self = Self {
        types: &[Type::Vec4],
        components: Components::FloatOrNormalized,
        text: "a VEC4 of floats or normalised unsigned bytes or shorts",
    };
    pub const JOINTS: Self = Self {
        types: &[Type::Vec4],
        components: Components::Unsigned8Or16,
        text: "a VEC4 of unsigned bytes or shorts",
    };
    pub const PLACES: Self =
        Self { types: &[Type::Vec3], components: Components::Float, text: "a float VEC3" };
    pub const ROTATIONS: Self = Self {
        types: &[Type::Vec4],
        components: Components::FloatOrNormalizedAny,
        text: "a VEC4 of floats or normalised bytes or shorts",
    };
    pub const SHARES: Self = Self {
        types: &[Type::Scalar],
        components: Components::FloatOrNormalizedAny,
        text: "a SCALAR of floats or normalised bytes or shorts",
    };
    #[cfg(feature = "measure")]
    pub const ANY: Self = Self {
        types: &[Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4, Type::Mat2, Type::Mat3, Type::Mat4],
        components: Components::Any,
        text: "an accessor",
    };
    pub const INDICES: Self = Self {
        types: &[Type::Scalar],
        components: Components::Unsigned,
        text: "a SCALAR of unsigned bytes, shorts or ints",
    };

    /// `quantized`: the file uses KHR_mesh_quantization.
    fn accepts(&self, type_: Type, component: ComponentType, normalized: bool, quantized: bool) -> bool {
        use ComponentType as C;
        let float_or_normalized = component == C::F32 || normalized && matches!(component, C::U8 | C::U16);
        let small = quantized && matches!(component, C::I8 | C::U8 | C::I16 | C::U16);
        self.types.contains(&type_)
            && match self.components {
                #[cfg(feature = "measure")]
                Components::Any => true,
                Components::Float => component == C::F32,
                Components::FloatOrQuantized => component == C::F32 || small,
                Components::FloatOrNormalized => float_or_normalized,
                Components::FloatOrNormalizedAny => {
                    float_or_normalized || normalized && matches!(component, C::I8 | C::I16)
                }
                Components::FloatNormalizedOrQuantized => float_or_normalized || small,
                Components::Unsigned8Or16 => !normalized && matches!(component, C::U8 | C::U16),
                Components::Unsigned => !normalized && matches!(component, C::U8 | C::U16 | C::U32),
            }
    }
}

/// Elements of equal size, `stride` bytes apart. All of them lie within `bytes`.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl Strided<'_> {
    fn element(&self, i: usize) -> &[u8] {
        &self.bytes[i * self.stride..i * self.stride + self.size]
    }
}

/// An accessor whose byte ranges have been checked.
pub struct Reader<'a> {
    pub count: usize,
    pub width: usize,
    component: ComponentType,
    normalized: bool,
    base: Option<Strided<'a>>,
    /// Which elements are replaced, and by what.
    sparse: Option<(Vec<u32>, Strided<'a>)>,
    /// For messages: the attribute that uses the accessor, and the accessor.
    element: String,
    name: String,
}

impl<'a> Reader<'a> {
    /// Checks the accessor that `element` refers to.
    pub fn new(
        doc: &'a Document,
        index: Index<json::Accessor>,
        element: impl Into<String>,
        format: Format,
    ) -> Result<Self> {
        let element = element.into();
        let accessor = doc.get(&doc.root.accessors, "accessors", index, element.as_str())?;
        let name = format!("accessors[{}]", index.value());
        let component = doc.valid(accessor.component_type, format!("{name}.componentType"))?.0;
        let type_ = doc.valid(accessor.type_, format!("{name}.type"))?;
        if !format.accepts(type_, component, accessor.normalized, doc.is_quantized()) {
            let normalized = if accessor.normalized { "normalised " } else { "" };
            let problem = format!("{name} is {normalized}{component:?} {type_:?}, not {}", format.text);
            return Err(doc.bad(
                element,
                problem,
                "export the file again with a format that glTF 2.0 allows",
            ));
        }
        let count = accessor.count.0;
        let limit = if accessor.buffer_view.is_some() { MAX_VERTICES as u64 * 4 } else { MAX_UNBACKED_COUNT };
        if count == 0 || count > limit {
            let problem = format!("is {count}, outside 1 to {limit}");
            return Err(doc.bad(format!("{name}.count"), problem, "export the file again"));
        }
        let count = count as usize;
        let width = type_.multiplicity();
        let size = width * component.size();
        let base = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                Some(strided(doc, view, offset, count, size, &name)?)
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(read_sparse(doc, sparse, count, size, &name)?),
            None => None,
        };
        let normalized = accessor.normalized;
        Ok(Self { count, width, component, normalized, base, sparse, element, name })
    }

    /// The elements as floats (normalised integers are scaled to [0, 1]); all are finite.
    pub fn floats<const N: usize>(&self, doc: &Document) -> Result<Vec<[f32; N]>> {
        let (component, normalized) = (self.component, self.normalized);
        let decode = |bytes: &[u8]| {
            let mut chunks = bytes.chunks_exact(component.size()).map(|c| float(component, normalized, c));
            std::array::from_fn(|_| chunks.next().unwrap_or(0.0))
        };
        let out: Vec<[f32; N]> = self.collect([0.0; N], decode);
        match out.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
            None => Ok(out),
            Some(i) => Err(doc.bad(
                &self.element,
                format!("element {i} of {} is {:?}, which is not finite", self.name, out[i]),
                "repair the data in the program that made it and export again",
            )),
        }
    }

    /// The elements as unsigned integers.
    pub fn integers<const N: usize>(&self) -> Vec<[u32; N]> {
        let component = self.component;
        self.collect([0; N], |bytes| {
            let mut chunks = bytes.chunks_exact(component.size()).map(unsigned);
            std::array::from_fn(|_| chunks.next().unwrap_or(0))
        })
    }

    /// The bytes of these elements, each at the next multiple of four as vertex attributes must be; and how far apart they
    /// are.
    #[cfg(feature = "measure")]
    pub fn rows(&self, elements: &[u32]) -> (Vec<u8>, usize) {
        let size = self.width * self.component.size();
        let stride = size.next_multiple_of(4);
        let replaced: std::collections::HashMap<u32, usize> =
            self.sparse.iter().flat_map(|(indices, _)| indices).zip(0..).map(|(&i, at)| (i, at)).collect();
        let mut bytes = vec![0; elements.len() * stride];
        for (row, &element) in bytes.chunks_exact_mut(stride).zip(elements) {
            match (&self.sparse, replaced.get(&element), &self.base) {
                (Some((_, values)), Some(&at), _) => row[..size].copy_from_slice(values.element(at)),
                (_, _, Some(base)) => row[..size].copy_from_slice(base.element(element as usize)),
                _ => {}
            }
        }
        (bytes, stride)
    }

    fn collect<T: Copy>(&self, zero: T, decode: impl Fn(&[u8]) -> T) -> Vec<T> {
        let mut out = match &self.base {
            Some(base) => (0..self.count).map(|i| decode(base.element(i))).collect(),
            None => vec![zero; self.count],
        };
        if let Some((indices, values)) = &self.sparse {
            for (i, &target) in indices.iter().enumerate() {
                out[target as usize] = decode(values.element(i));
            }
        }
        out
    }
}

fn read_sparse<'a>(
    doc: &'a Document,
    sparse: &json::accessor::sparse::Sparse,
    count: usize,
    size: usize,
    accessor: &str,
) -> Result<(Vec<u32>, Strided<'a>)> {
    let name = format!("{accessor}.sparse");
    let replaced = sparse.count.0;
    if replaced > count as u64 {
        let problem = format!("is {replaced}, more than the accessor's {count} elements");
        return Err(doc.bad(format!("{name}.count"), problem, "export the file again"));
    }
    let replaced = replaced as usize;
    let component = doc.valid(sparse.indices.component_type, format!("{name}.indices.componentType"))?.0;
    let indices_name = format!("{name}.indices");
    let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
    let bytes = strided(doc, view, offset, replaced, component.size(), &indices_name)?;
    let indices: Vec<u32> = (0..replaced).map(|i| unsigned(bytes.element(i))).collect();
    if let Some(beyond) = indices.iter().find(|&&i| i as usize >= count) {
        let problem = format!("replaces element {beyond} of {count}");
        return Err(doc.bad(indices_name, problem, "export the file again"));
    }
    let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
    let values = strided(doc, view, offset, replaced, size, &format!("{name}.values"))?;
    Ok((indices, values))
}

fn strided<'a>(
    doc: &'a Document,
    view: Index<json::buffer::View>,
    offset: u64,
    count: usize,
    size: usize,
    name: &str,
) -> Result<Strided<'a>> {
    let bytes = doc.view(view, &format!("{name}.bufferView"))?;
    let stride = doc.root.buffer_views[view.value()].byte_stride.map_or(size, |s| s.0);
    if stride < size || stride > 252.max(size) {
        let problem = format!("is {stride}, but {name} has elements of {size} bytes");
        let element = format!("bufferViews[{}].byteStride", view.value());
        return Err(doc.bad(element, problem, "correct the stride (at most 252) or export the file again"));
    }
    let needed = match count {
        0 => 0,
        _ => (stride as u64) * (count as u64 - 1) + size as u64,
    };
    let end = offset.checked_add(needed).filter(|&end| end <= bytes.len() as u64);
    let Some(end) = end else {
        let problem = format!(
            "needs {needed} bytes from byte {offset} on, but bufferViews[{}] has {}",
            view.value(),
            bytes.len()
        );
        return Err(doc.bad(name, problem, "correct count and byteOffset or export the file again"));
    };
    Ok(Strided { bytes: &bytes[offset as usize..end as usize], stride, size })
}

/// glTF 2.0 section 3.6.2.2: normalised integers span 0 to 1, signed ones -1 to 1; others are their own value.
fn float(component: ComponentType, normalized: bool, bytes: &[u8]) -> f32 {
    let (value, most) = match (component, bytes) {
        (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        (ComponentType::I8, &[a]) => (f32::from(a.cast_signed()), 127.0),
        (ComponentType::U8, &[a]) => (f32::from(a), 255.0),
        (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        _ => return 0.0,
    };
    if normalized { (value / most).max(-1.0) } else { value }
}

/// Little-endian, one to four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
