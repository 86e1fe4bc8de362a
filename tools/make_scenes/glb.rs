//! A writer of binary glTF 2.0: one JSON chunk, one BIN chunk, keys in a fixed order.

pub mod moving;

pub use super::model::{Light, LightKind, Material, Medium, Pose, Slot};

use super::mesh::Mesh;
use super::texture::{Encoded, Mime, Surface};
use glam::{Quat, Vec2, Vec3, Vec4};
use serde_json::{Map, Value, json};
use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};

/// Index of an accessor set in the file.
#[derive(Clone)]
pub struct Geometry {
    attributes: Value,
    indices: usize,
}

/// A file in the making.
#[derive(Default)]
pub struct Glb {
    lists: BTreeMap<&'static str, Vec<Value>>,
    lights: Vec<Value>,
    extensions: BTreeSet<&'static str>,
    binary: Vec<u8>,
    is_child: BTreeSet<usize>,
    scene_extras: Option<Value>,
}

impl Glb {
    /// Embeds a picture and gives the slot that shows it once over [0, 1], repeating, trilinear.
    pub fn texture(&mut self, name: &str, picture: &Encoded) -> Slot {
        if !self.lists.contains_key("samplers") {
            // OpenGL's LINEAR, LINEAR_MIPMAP_LINEAR and REPEAT, as glTF numbers them.
            self.add(
                "samplers",
                json!({"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}),
            );
        }
        let view = self.view(&picture.bytes, None);
        let mime = match picture.mime {
            Mime::Png => "image/png",
            Mime::Jpeg => "image/jpeg",
        };
        let image = self.add("images", json!({"name": name, "bufferView": view, "mimeType": mime}));
        let texture = self.add("textures", json!({"name": name, "sampler": 0, "source": image}));
        Slot { texture, scale: Vec2::ONE }
    }

    /// Adds a material.
    pub fn material(&mut self, m: &Material) -> usize {
        let mut pbr = Map::new();
        pbr.insert(
            "baseColorFactor".into(),
            numbers(m.base_color.extend(m.blend_alpha.unwrap_or(1.0)).to_array()),
        );
        pbr.insert("metallicFactor".into(), number(m.metallic));
        pbr.insert("roughnessFactor".into(), number(m.roughness));
        self.slot(&mut pbr, "baseColorTexture", m.base_color_texture);
        self.slot(&mut pbr, "metallicRoughnessTexture", m.metallic_roughness_texture);
        let mut material = Map::new();
        material.insert("name".into(), json!(m.name));
        material.insert("pbrMetallicRoughness".into(), Value::Object(pbr));
        self.slot(&mut material, "normalTexture", m.normal_texture);
        if let Some(normal) = material.get_mut("normalTexture").filter(|_| m.normal_scale != 1.0) {
            normal["scale"] = number(m.normal_scale);
        }
        self.slot(&mut material, "occlusionTexture", m.occlusion_texture);
        self.slot(&mut material, "emissiveTexture", m.emissive_texture);
        if m.emissive != Vec3::ZERO {
            material.insert("emissiveFactor".into(), numbers(m.emissive.to_array()));
        }
        if let Some(cutoff) = m.alpha_cutoff {
            material.insert("alphaMode".into(), json!("MASK"));
            material.insert("alphaCutoff".into(), number(cutoff));
        }
        if m.blend_alpha.is_some() {
            material.insert("alphaMode".into(), json!("BLEND"));
        }
        if m.double_sided {
            material.insert("doubleSided".into(), json!(true));
        }
        let mut extensions = Map::new();
        if m.emissive_strength != 1.0 {
            let strength = json!({"emissiveStrength": number(m.emissive_strength)});
            extensions.insert(self.uses("KHR_materials_emissive_strength"), strength);
        }
        if let Some(medium) = m.medium {
            let transmission = json!({"transmissionFactor": number(medium.transmission)});
            extensions.insert(self.uses("KHR_materials_transmission"), transmission);
            extensions.insert(self.uses("KHR_materials_ior"), json!({"ior": number(medium.ior)}));
            let volume = json!({
                "thicknessFactor": number(medium.thickness_m),
                "attenuationColor": numbers(medium.color.to_array()),
                "attenuationDistance": number(medium.distance_m),
            });
            extensions.insert(self.uses("KHR_materials_volume"), volume);
        }
        if m.unlit {
            extensions.insert(self.uses("KHR_materials_unlit"), json!({}));
        }
        if !extensions.is_empty() {
            material.insert("extensions".into(), Value::Object(extensions));
        }
        self.add("materials", Value::Object(material))
    }

    /// A material of a surface's three textures, which repeat `per_m` times a metre.
    pub fn textured(&mut self, name: &'static str, surface: &Surface, per_m: f32) -> Material {
        let maps = surface.maps();
        let orm =
            self.texture(&format!("{name} occlusion roughness metallic"), &maps.occlusion_roughness_metallic);
        Material {
            name,
            base_color_texture: Some(self.texture(name, &maps.base_color).scaled(per_m)),
            metallic: 1.0,
            metallic_roughness_texture: Some(orm.scaled(per_m)),
            normal_texture: Some(self.texture(&format!("{name} normal"), &maps.normal).scaled(per_m)),
            occlusion_texture: Some(orm.scaled(per_m)),
            ..Material::default()
        }
    }

    /// Stores a mesh's vertices and triangles once, for any number of [`Self::mesh`].
    pub fn geometry(&mut self, mesh: &Mesh) -> Geometry {
        let floats =
            |list: &[Vec3]| list.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect();
        let mut attributes = Map::new();
        let positions: Vec<u8> = floats(&mesh.positions);
        let position = self.accessor(&positions, 12, 5126, "VEC3");
        let low = mesh.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let accessor = &mut self.lists.get_mut("accessors").expect("just added")[position];
        accessor["min"] = json!(low.to_array());
        accessor["max"] = json!(high.to_array());
        attributes.insert("POSITION".into(), json!(position));
        if !mesh.normals.is_empty() {
            let normals: Vec<u8> = floats(&mesh.normals);
            attributes.insert("NORMAL".into(), json!(self.accessor(&normals, 12, 5126, "VEC3")));
        }
        if !mesh.tangents.is_empty() {
            let bytes: Vec<u8> =
                mesh.tangents.iter().flat_map(Vec4::to_array).flat_map(f32::to_le_bytes).collect();
            attributes.insert("TANGENT".into(), json!(self.accessor(&bytes, 16, 5126, "VEC4")));
        }
        if !mesh.texcoords.is_empty() {
            let bytes: Vec<u8> =
                mesh.texcoords.iter().flat_map(Vec2::to_array).flat_map(f32::to_le_bytes).collect();
            attributes.insert("TEXCOORD_0".into(), json!(self.accessor(&bytes, 8, 5126, "VEC2")));
        }
        if !mesh.colors.is_empty() {
            let bytes: Vec<u8> = (mesh.colors.iter().flat_map(Vec4::to_array))
                .flat_map(|c| ((c.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())
                .collect();
            let color = self.accessor(&bytes, 8, 5123, "VEC4");
            self.lists.get_mut("accessors").expect("just added")[color]["normalized"] = json!(true);
            attributes.insert("COLOR_0".into(), json!(color));
        }
        let fits_u16 = mesh.positions.len() < usize::from(u16::MAX);
        let (bytes, component): (Vec<u8>, _) = if fits_u16 {
            (mesh.indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect(), 5123)
        } else {
            (mesh.indices.iter().flat_map(|&i| i.to_le_bytes()).collect(), 5125)
        };
        let view = self.view(&bytes, Some(34963));
        let indices = self.add(
            "accessors",
            json!({"bufferView": view, "componentType": component, "count": mesh.indices.len(), "type": "SCALAR"}),
        );
        Geometry { attributes: Value::Object(attributes), indices }
    }

    /// Adds a mesh of one primitive for each pair of geometry and material.
    pub fn mesh(&mut self, name: &str, primitives: &[(&Geometry, usize)]) -> usize {
        let primitive = |(geometry, material): &(&Geometry, usize)| json!({"attributes": geometry.attributes, "indices": geometry.indices, "material": material});
        let primitives: Vec<_> = primitives.iter().map(primitive).collect();
        self.add("meshes", json!({"name": name, "primitives": primitives}))
    }

    /// Adds a mesh of points, each with a linear colour from 0 to 1, a size and a rotation in radians, for [`Self::extras`] to make
    /// particles of.
    pub fn points(&mut self, name: &str, points: &[(Vec3, Vec3, f32, f32)], material: usize) -> usize {
        let mut list = |width: u32, floats: Vec<f32>| {
            let bytes: Vec<u8> = floats.into_iter().flat_map(f32::to_le_bytes).collect();
            self.accessor(&bytes, width as usize * 4, 5126, if width == 1 { "SCALAR" } else { "VEC3" })
        };
        let positions = list(3, points.iter().flat_map(|p| p.0.to_array()).collect());
        let colors = list(3, points.iter().flat_map(|p| p.1.to_array()).collect());
        let sizes = list(1, points.iter().map(|p| p.2).collect());
        let rotations = list(1, points.iter().map(|p| p.3).collect());
        let low = points.iter().map(|p| p.0).fold(Vec3::INFINITY, Vec3::min);
        let high = points.iter().map(|p| p.0).fold(Vec3::NEG_INFINITY, Vec3::max);
        let accessor = &mut self.lists.get_mut("accessors").expect("just added")[positions];
        accessor["min"] = json!(low.to_array());
        accessor["max"] = json!(high.to_array());
        let attributes =
            json!({"POSITION": positions, "COLOR_0": colors, "_SIZE": sizes, "_ROTATION": rotations});
        let primitive = json!({"attributes": attributes, "mode": 0, "material": material});
        self.add("meshes", json!({"name": name, "primitives": [primitive]}))
    }

    /// Places a mesh.
    pub fn place(&mut self, name: &str, mesh: usize, pose: Pose) -> usize {
        self.node(name, pose, json!({"mesh": mesh}))
    }

    /// A node that nothing stands at.
    pub fn empty(&mut self, name: &str, pose: Pose) -> usize {
        self.node(name, pose, json!({}))
    }

    /// Places nodes together; they stop being roots.
    pub fn group(&mut self, name: &str, children: &[usize], pose: Pose) -> usize {
        self.is_child.extend(children);
        self.node(name, pose, json!({"children": children}))
    }

    /// Adds a light and places it.
    pub fn light(&mut self, light: Light, pose: Pose) -> usize {
        let mut value = json!({"name": light.name, "color": numbers(light.color.to_array())});
        match light.kind {
            LightKind::Directional { illuminance_lx } => {
                value["type"] = json!("directional");
                value["intensity"] = number(illuminance_lx);
            }
            LightKind::Point { intensity_cd, range_m } => {
                value["type"] = json!("point");
                value["intensity"] = number(intensity_cd);
                value["range"] = number(range_m);
            }
            LightKind::Spot { intensity_cd, range_m, inner_rad, outer_rad } => {
                value["type"] = json!("spot");
                value["intensity"] = number(intensity_cd);
                value["range"] = number(range_m);
                value["spot"] =
                    json!({"innerConeAngle": number(inner_rad), "outerConeAngle": number(outer_rad)});
            }
        }
        // Equal lights are one entry with many nodes.
        let index = self.lights.iter().position(|known| *known == value).unwrap_or_else(|| {
            self.lights.push(value);
            self.lights.len() - 1
        });
        let extension = self.uses("KHR_lights_punctual");
        self.node(light.name, pose, json!({"extensions": {extension: {"light": index}}}))
    }

    /// What ontile reads of a node besides glTF: its `extras`.
    pub fn extras(&mut self, node: usize, ontile: Value) {
        self.lists.get_mut("nodes").expect("the node exists")[node]["extras"] = json!({"ontile": ontile});
    }

    /// The same of the scene.
    pub fn scene_extras(&mut self, ontile: Value) {
        self.scene_extras = Some(json!({"ontile": ontile}));
    }

    /// Adds and places a pinhole camera with this vertical field of view. Its far plane is at infinity.
    pub fn perspective(&mut self, name: &str, yfov_deg: f32, pose: Pose) {
        let yfov = number(yfov_deg.to_radians());
        let perspective = json!({"aspectRatio": 16.0 / 9.0, "yfov": yfov, "znear": 0.05});
        let camera =
            self.add("cameras", json!({"name": name, "type": "perspective", "perspective": perspective}));
        self.node(name, pose, json!({"camera": camera}));
    }

    /// Adds and places a parallel camera of this half height, 16:9.
    pub fn orthographic(&mut self, name: &str, ymag_m: f32, zfar_m: f32, pose: Pose) {
        let orthographic = json!({
            "xmag": number(ymag_m * 16.0 / 9.0), "ymag": number(ymag_m), "znear": 0.1, "zfar": number(zfar_m),
        });
        let camera =
            self.add("cameras", json!({"name": name, "type": "orthographic", "orthographic": orthographic}));
        self.node(name, pose, json!({"camera": camera}));
    }

    /// The finished file.
    pub fn finish(mut self, name: &str) -> Vec<u8> {
        let node_count = self.lists.get("nodes").map_or(0, Vec::len);
        let roots: Vec<_> = (0..node_count).filter(|i| !self.is_child.contains(i)).collect();
        let mut json = Map::new();
        json.insert("asset".into(), json!({"version": "2.0", "generator": "make_scenes"}));
        json.insert("scene".into(), json!(0));
        let mut scene = json!({"name": name, "nodes": roots});
        if let Some(extras) = self.scene_extras.take() {
            scene["extras"] = extras;
        }
        json.insert("scenes".into(), json!([scene]));
        json.insert("buffers".into(), json!([{"byteLength": self.binary.len()}]));
        for (list, values) in std::mem::take(&mut self.lists) {
            json.insert(list.into(), Value::Array(values));
        }
        if !self.lights.is_empty() {
            json.insert("extensions".into(), json!({"KHR_lights_punctual": {"lights": self.lights}}));
        }
        if !self.extensions.is_empty() {
            json.insert("extensionsUsed".into(), json!(self.extensions));
        }
        let mut text = Value::Object(json).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() + 8 + self.binary.len();
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((total as u32).to_le_bytes());
        for (tag, chunk) in [(b"JSON", &text), (b"BIN\0", &self.binary)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(tag);
            file.extend(chunk);
        }
        file
    }

    fn uses(&mut self, extension: &'static str) -> String {
        self.extensions.insert(extension);
        extension.into()
    }

    fn add(&mut self, list: &'static str, value: Value) -> usize {
        let list = self.lists.entry(list).or_default();
        list.push(value);
        list.len() - 1
    }

    fn node(&mut self, name: &str, pose: Pose, mut node: Value) -> usize {
        node["name"] = json!(name);
        if pose.position_m != Vec3::ZERO {
            node["translation"] = numbers(pose.position_m.to_array());
        }
        if pose.rotation != Quat::IDENTITY {
            node["rotation"] = numbers(pose.rotation.to_array());
        }
        if pose.scale != Vec3::ONE {
            node["scale"] = numbers(pose.scale.to_array());
        }
        self.add("nodes", node)
    }

    fn slot(&mut self, target: &mut Map<String, Value>, key: &str, slot: Option<Slot>) {
        let Some(slot) = slot else { return };
        let mut value = json!({"index": slot.texture});
        if slot.scale != Vec2::ONE {
            let extension = self.uses("KHR_texture_transform");
            value["extensions"] = json!({extension: {"scale": numbers(slot.scale.to_array())}});
        }
        target.insert(key.into(), value);
    }

    /// `stride` bytes make one element. Vertex data start at multiples of four bytes.
    fn accessor(&mut self, bytes: &[u8], stride: usize, component: u32, shape: &str) -> usize {
        let view = self.view(bytes, Some(34962));
        let count = bytes.len() / stride;
        self.add(
            "accessors",
            json!({"bufferView": view, "componentType": component, "count": count, "type": shape}),
        )
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.add("bufferViews", view)
    }
}

/// The shortest decimal that reads back as this number.
fn number(x: f32) -> Value {
    json!(x.to_string().parse::<f64>().expect("a printed number parses"))
}

fn numbers<const N: usize>(values: [f32; N]) -> Value {
    Value::Array(values.into_iter().map(number).collect())
}

/// Places a mesh that nothing else uses, with a material of the same name.
pub fn place(glb: &mut Glb, name: &'static str, mesh: impl Borrow<Mesh>, material: &Material, pose: Pose) {
    let geometry = glb.geometry(mesh.borrow());
    let material = glb.material(&Material { name, ..material.clone() });
    let mesh = glb.mesh(name, &[(&geometry, material)]);
    glb.place(name, mesh, pose);
}

/// A decal: a box of this size around a place, which paints along its -Z.
pub fn paint(glb: &mut Glb, name: &str, material: usize, pose: Pose, size_m: Vec3, more: Value) {
    let node = glb.empty(name, pose);
    let mut decal = json!({"material": material, "size": size_m.to_array()});
    let more = more.as_object().cloned().unwrap_or_default();
    decal.as_object_mut().expect("made as one").extend(more);
    glb.extras(node, json!({"decal": decal}));
}
