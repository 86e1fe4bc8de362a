//! Which triangle a ray meets first.

use glam::{DMat3, DMat4, DVec3};

use super::bvh::{Bounds, Bvh};
use super::gbuffer;
use super::view::Ray;
use crate::scene::{AlphaMode, Instance, Material, Posed, Scene};

/// A scene's triangles in world space, ready for rays.
pub struct Visibility<'a> {
    pub(super) scene: &'a Scene,
    pub(super) placements: Vec<Placement>,
    pub(super) triangles: Vec<Triangle>,
    /// By mesh, of those that are drawn and bend.
    pub(super) posed: Vec<Option<Posed>>,
    bvh: Bvh,
}

/// An instance's transforms.
pub(super) struct Placement {
    pub world_from_object: DMat4,
    /// For normals: the cofactors, so that flattening scales need no inverse, with the determinant's sign.
    pub normal_world_from_object: DMat3,
    pub mirrored: bool,
}

pub(super) struct Triangle {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Indices into the mesh's vertices.
    pub vertices: [u32; 3],
    pub corners_world: [DVec3; 3],
    /// Front faces are wound counter-clockwise in *object* space: a mirroring instance turns them round.
    pub mirrored: bool,
    pub double_sided: bool,
    /// Discard where alpha is below this.
    pub alpha_cutoff: Option<f32>,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Along the view axis, metres.
    pub distance: f64,
    /// Index into the triangles of all instances, in order of drawing.
    pub triangle: u32,
    /// Weights of the three corners; they sum to 1.
    pub barycentric: [f64; 3],
    /// Whether the front side is seen.
    pub front_facing: bool,
}

impl<'a> Visibility<'a> {
    /// Transforms every triangle of every instance to world space, but for those that are blended: they hide nothing
    /// ([`Self::blended`]).
    ///
    /// # Panics
    /// If an index within the scene is out of range.
    pub fn new(scene: &'a Scene) -> Self {
        Self::of(scene, |_| true)
    }

    /// As [`Self::new`], with some of the instances only.
    ///
    /// # Panics
    /// If an index within the scene is out of range.
    pub fn of(scene: &'a Scene, wanted: impl Fn(&Instance) -> bool) -> Self {
        Self::with(scene, |instance| !scene.is_blended(instance) && wanted(instance))
    }

    /// Of what is blended alone.
    ///
    /// # Panics
    /// If an index within the scene is out of range.
    pub fn blended(scene: &'a Scene) -> Self {
        Self::with(scene, |instance| scene.is_blended(instance))
    }

    fn with(scene: &'a Scene, wanted: impl Fn(&Instance) -> bool) -> Self {
        let placements: Vec<_> =
            scene.instances.iter().map(|i| Placement::new(i.world_from_object.as_dmat4())).collect();
        let mut posed = vec![None; scene.meshes.len()];
        for instance in scene.instances.iter().filter(|i| scene.is_drawn(i) && wanted(i)) {
            let place: &mut Option<Posed> = &mut posed[instance.mesh];
            *place = place.take().or_else(|| scene.meshes[instance.mesh].posed_vertices());
        }
        let mut triangles = Vec::with_capacity(scene.triangle_count());
        let all = scene.instances.iter().zip(&placements).enumerate();
        for (index, (instance, placement)) in all.filter(|(_, (i, _))| scene.is_drawn(i) && wanted(i)) {
            let mesh = &scene.meshes[instance.mesh];
            let material = &scene.materials[mesh.material];
            let alpha_cutoff = match material.alpha_mode {
                AlphaMode::Opaque | AlphaMode::Blend => None,
                AlphaMode::Mask { cutoff } => Some(cutoff),
            };
            triangles.extend(mesh.indices.chunks_exact(3).map(|chunk| {
                let vertices = [chunk[0], chunk[1], chunk[2]];
                Triangle {
                    instance: index as u32,
                    vertices,
                    corners_world: vertices.map(|v| {
                        let position = match &posed[instance.mesh] {
                            Some(posed) => posed.positions[v as usize],
                            None => mesh.positions[v as usize].as_dvec3(),
                        };
                        placement.world_from_object.transform_point3(position)
                    }),
                    mirrored: placement.mirrored,
                    double_sided: material.double_sided,
                    alpha_cutoff,
                }
            }));
        }
        let bounds: Vec<_> = triangles.iter().map(|t| Bounds::of(&t.corners_world)).collect();
        Self { scene, placements, triangles, posed, bvh: Bvh::build(&bounds) }
    }

    /// The nearest triangle that the ray meets between its near and far planes: back faces of single-sided
    /// materials and masked-out places are passed through. Of equally near ones the first drawn wins, as with a
    /// strict depth test.
    pub fn trace(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, |hit| self.is_drawn(hit))
    }

    /// As [`Self::trace`], but sides that are never drawn stop the ray too.
    pub fn trace_solid(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, |_| true)
    }

    /// All triangles that the ray meets nearer than `end`, from near to far; of equally near ones the last drawn is nearest.
    pub fn trace_all(&self, ray: &Ray, end: f64) -> Vec<Hit> {
        let prepared = Sheared::new(ray);
        let mut all = Vec::new();
        self.bvh.traverse(ray, |item| {
            all.extend(self.candidate(&prepared, ray, item, |hit| self.is_drawn(hit) && hit.distance < end));
            ray.range[1]
        });
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(b.triangle.cmp(&a.triangle)));
        all
    }

    /// Whether [`Self::trace_solid`] meets anything.
    pub fn is_blocked(&self, ray: &Ray) -> bool {
        let prepared = Sheared::new(ray);
        let mut blocked = false;
        self.bvh.traverse(ray, |item| {
            blocked = blocked || self.candidate(&prepared, ray, item, |_| true).is_some();
            if blocked { f64::NEG_INFINITY } else { ray.range[1] }
        });
        blocked
    }

    /// Whether the side of the surface that a ray met is drawn: fronts, and backs of double-sided materials.
    pub fn is_drawn(&self, hit: &Hit) -> bool {
        hit.front_facing || self.triangles[hit.triangle as usize].double_sided
    }

    fn nearest(&self, ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let prepared = Sheared::new(ray);
        let mut nearest: Option<Hit> = None;
        self.bvh.traverse(ray, |item| {
            if let Some(hit) = self.candidate(&prepared, ray, item, &counts)
                && nearest.is_none_or(|n| (hit.distance, hit.triangle) < (n.distance, n.triangle))
            {
                nearest = Some(hit);
            }
            nearest.map_or(ray.range[1], |n| n.distance)
        });
        nearest
    }

    /// The intersection of the ray with one triangle, if the triangle is solid there and the hit counts.
    fn candidate(
        &self,
        prepared: &Sheared,
        ray: &Ray,
        index: u32,
        counts: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let triangle = &self.triangles[index as usize];
        let crossing = prepared.intersect(&triangle.corners_world)?;
        let hit = Hit {
            distance: crossing.distance,
            triangle: index,
            barycentric: crossing.barycentric,
            front_facing: crossing.counter_clockwise != triangle.mirrored,
        };
        if !(ray.range[0]..=ray.range[1]).contains(&hit.distance) || !counts(&hit) {
            return None;
        }
        match triangle.alpha_cutoff {
            Some(cutoff) if gbuffer::alpha(self, &hit) < f64::from(cutoff) => None,
            _ => Some(hit),
        }
    }

    /// The hit of a ray with the plane of one triangle, also outside of the triangle: extrapolation.
    pub(super) fn extrapolate(&self, ray: &Ray, triangle: u32, front_facing: bool) -> Option<Hit> {
        let [a, b, c] = self.triangles[triangle as usize].corners_world;
        let normal = (b - a).cross(c - a);
        let distance = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
        let point = ray.at(distance);
        let weight = |p: DVec3, q: DVec3| (p - point).cross(q - point).dot(normal) / normal.length_squared();
        let barycentric = [weight(b, c), weight(c, a), weight(a, b)];
        (distance.is_finite() && barycentric.iter().all(|w| w.is_finite())).then_some(Hit {
            distance,
            triangle,
            barycentric,
            front_facing,
        })
    }

    /// The instance that a hit belongs to, as an index into `Scene::instances`.
    pub fn instance(&self, hit: &Hit) -> usize {
        self.triangles[hit.triangle as usize].instance as usize
    }

    /// Unit normal of the hit triangle's plane, by its winding in world space.
    pub(super) fn plane_normal(&self, hit: &Hit) -> DVec3 {
        let [a, b, c] = self.triangles[hit.triangle as usize].corners_world;
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Unit normal of the hit triangle's plane on its front side, whichever way the instance winds it.
    pub(super) fn front_normal(&self, hit: &Hit) -> DVec3 {
        let mirrored = self.triangles[hit.triangle as usize].mirrored;
        self.plane_normal(hit) * if mirrored { -1.0 } else { 1.0 }
    }

    /// The material of a triangle.
    pub(super) fn material(&self, triangle: u32) -> &'a Material {
        let instance = self.triangles[triangle as usize].instance as usize;
        &self.scene.materials[self.scene.meshes[self.scene.instances[instance].mesh].material]
    }
}

impl Placement {
    fn new(world_from_object: DMat4) -> Self {
        let m = DMat3::from_mat4(world_from_object);
        let mirrored = m.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let cofactors =
            DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        Self { world_from_object, normal_world_from_object: cofactors * sign, mirrored }
    }
}

/// A ray in the coordinates of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013:
/// the ray becomes the z axis, so that a triangle is hit when its projection contains the origin. Neighbouring
/// triangles evaluate their common edge with the same numbers, so no ray slips between them.
struct Sheared {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

/// An intersection before culling.
struct Crossing {
    distance: f64,
    barycentric: [f64; 3],
    /// As seen from the ray's origin.
    counter_clockwise: bool,
}

impl Sheared {
    fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let size = d.abs();
        let z = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            (x, y) = (y, x);
        }
        Self { origin: ray.origin, axes: [x, y, z], shear: DVec3::new(d[x], d[y], 1.0) / d[z] }
    }

    fn intersect(&self, corners: &[DVec3; 3]) -> Option<Crossing> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            DVec3::new(p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], self.shear.z * p[z])
        });
        let (u, v, w) = (c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let sum = u + v + w;
        if !inside || sum == 0.0 {
            return None;
        }
        Some(Crossing {
            distance: (u * a.z + v * b.z + w * c.z) / sum,
            barycentric: [u / sum, v / sum, w / sum],
            counter_clockwise: sum > 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{camera_at, orthographic, perspective, scene_of, square};
    use crate::reference::view::View;
    use crate::scene::Mesh;
    use glam::{Mat4, Vec3, Vec4};

    /// A repeatable sequence in \[0, 1): Knuth's 64-bit linear congruential generator.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Möller and Trumbore 1997, without culling: independent of the sheared test.
    fn moller_trumbore(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<f64> {
        let (ab, ac) = (b - a, c - a);
        let p = ray.direction.cross(ac);
        let determinant = ab.dot(p);
        let to_origin = ray.origin - a;
        let u = to_origin.dot(p) / determinant;
        let q = to_origin.cross(ab);
        let v = ray.direction.dot(q) / determinant;
        let t = ac.dot(q) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (ray.range[0]..=ray.range[1]).contains(&t)).then_some(t)
    }

    #[test]
    fn the_hierarchy_finds_what_trying_all_triangles_finds() {
        let mut state = 7;
        let mut point =
            |scale: f64| DVec3::from_array(std::array::from_fn(|_| (random(&mut state) - 0.5) * scale));
        let mut mesh = Mesh::default();
        for _ in 0..500 {
            let center = point(10.0);
            mesh.positions.extend([0; 3].map(|_| (center + point(2.0)).as_vec3()));
        }
        mesh.indices = (0..1500).collect();
        let material = Material { double_sided: true, unlit: true, ..Material::default() };
        let scene = scene_of(material, vec![(mesh, Mat4::IDENTITY)]);
        let visibility = Visibility::new(&scene);
        let mut hits = 0;
        for _ in 0..2000 {
            let (origin, target) = (point(30.0), point(8.0));
            let ray = Ray { origin, direction: target - origin, range: [0.05, 1.5] };
            let expected = visibility.triangles.iter().filter_map(|t| moller_trumbore(&ray, t.corners_world));
            let expected = expected.fold(f64::INFINITY, f64::min);
            let found = visibility.trace(&ray).map_or(f64::INFINITY, |h| h.distance);
            assert!(found == expected || (found - expected).abs() < 1e-9, "{found} {expected}");
            hits += usize::from(expected.is_finite());
        }
        assert!(hits > 500 && hits < 2000, "{hits}");
    }

    #[test]
    fn barycentric_weights_give_the_point_back() {
        let scene = scene_of(Material::default(), vec![(square(1.0), Mat4::IDENTITY)]);
        let visibility = Visibility::new(&scene);
        let ray = Ray { origin: DVec3::new(0.3, -0.6, 2.0), direction: DVec3::NEG_Z, range: [0.0, 10.0] };
        let hit = visibility.trace(&ray).unwrap();
        let corners = visibility.triangles[hit.triangle as usize].corners_world;
        let point: DVec3 = (0..3).map(|k| corners[k] * hit.barycentric[k]).sum();
        assert!((point - DVec3::new(0.3, -0.6, 0.0)).length() < 1e-15);
        assert_eq!(hit.distance, 2.0);
        let plane = visibility.extrapolate(&ray, hit.triangle, true).unwrap();
        assert!((plane.distance - 2.0).abs() < 1e-15);
        assert!((0..3).all(|k| (plane.barycentric[k] - hit.barycentric[k]).abs() < 1e-15));
    }

    #[test]
    fn no_ray_slips_through_a_common_edge_or_vertex() {
        let scene = scene_of(Material::default(), vec![(square(1.0), Mat4::IDENTITY)]);
        let visibility = Visibility::new(&scene);
        let origin = DVec3::new(0.17, 0.31, 1.7);
        for step in -99..100 {
            // Along the diagonal between the two triangles.
            let s = f64::from(step) / 100.0;
            let ray = Ray { origin, direction: DVec3::new(s, -s, 0.0) - origin, range: [0.0, 9.0] };
            assert!(visibility.trace(&ray).is_some(), "{s}");
        }
    }

    /// Whether a square, placed so and seen from +Z, is visible; and from -Z.
    fn seen(placement: Mat4, double_sided: bool) -> [Option<bool>; 2] {
        let scene =
            scene_of(Material { double_sided, ..Material::default() }, vec![(square(1.0), placement)]);
        let visibility = Visibility::new(&scene);
        [3.0, -3.0].map(|z| {
            let ray = Ray { origin: DVec3::Z * z, direction: DVec3::Z * -z, range: [0.0, 9.0] };
            visibility.trace(&ray).map(|hit| hit.front_facing)
        })
    }

    #[test]
    fn a_mirrored_instance_keeps_its_front() {
        let mirrored = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let turned = Mat4::from_rotation_y(std::f32::consts::PI);
        assert_eq!(seen(Mat4::IDENTITY, false), [Some(true), None]);
        assert_eq!(seen(mirrored, false), [Some(true), None]);
        assert_eq!(seen(turned, false), [None, Some(true)]);
        assert_eq!(seen(Mat4::from_scale(-Vec3::ONE), false), [None, Some(true)]);
        assert_eq!(seen(mirrored, true), [Some(true), Some(false)]);
    }

    #[test]
    fn near_and_far_planes_clip() {
        let scene = scene_of(
            Material::default(),
            [-0.5_f32, -3.0, -30.0].map(|z| (square(1.0), Mat4::from_translation(Vec3::Z * z))).to_vec(),
        );
        let visibility = Visibility::new(&scene);
        let first = |near, far| {
            let camera = camera_at(Vec3::ZERO, Vec3::NEG_Z, perspective(0.5, near, far));
            visibility.trace(&View::new(&camera, [1, 1]).ray_through_pixel([0, 0])).map(|h| h.distance)
        };
        assert_eq!(first(0.1, None), Some(0.5));
        assert_eq!(first(1.0, None), Some(3.0));
        assert_eq!(first(4.0, None), Some(30.0));
        assert_eq!(first(4.0, Some(20.0)), None);
    }

    #[test]
    fn a_mask_lets_rays_through_where_vertex_alpha_is_low() {
        let mut front = square(1.0);
        // Alpha grows from 0 at the left to 1 at the right.
        front.colors = front.positions.iter().map(|p| Vec4::new(1.0, 1.0, 1.0, p.x * 0.5 + 0.5)).collect();
        let material = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.25 }, ..Material::default() };
        let scene = scene_of(
            material,
            vec![(front, Mat4::IDENTITY), (square(1.0), Mat4::from_translation(Vec3::NEG_Z))],
        );
        let visibility = Visibility::new(&scene);
        let camera = camera_at(Vec3::Z, Vec3::ZERO, orthographic());
        let view = View::new(&camera, [400, 400]);
        for x in 105..295 {
            // Pixel x is at (x + 0.5) / 100 - 2 metres; the cutoff at alpha 0.25 lies at -0.5 metres.
            let hit = visibility.trace(&view.ray_through_pixel([x, 200])).unwrap();
            assert_eq!(visibility.instance(&hit), usize::from(x < 150), "{x}");
        }
    }
}
