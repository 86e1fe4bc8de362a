//! What is measured for each table.

use std::rc::Rc;

use ontile::Result;
use ontile::gpu::Device;
use ontile::plan::{LightWay, Options, Path};
use ontile::scene::Scene;

use super::data::TableName;
use super::measure::{Case, Way, lit_share};
use super::scenes;

/// What the tables have in common.
pub struct Settings {
    /// Of the exterior and the interior.
    pub sizes: Vec<[u32; 2]>,
    /// Of what the dissertation measured at one size.
    pub view_size: [u32; 2],
    /// Of the sweeps over lights and layers.
    pub sweep_size: [u32; 2],
    /// Where the sweep over lights ends.
    pub most_lights: usize,
    /// Fewer places in each sweep.
    pub quick: bool,
}

/// The ways of a table are named by what differs.
pub const DEFERRED: &str = Path::Deferred.name();
pub const FORWARD: &str = Path::Forward.name();
pub const MULTIPASS: &str = Path::ForwardMultipass.name();
pub const FULLSCREEN: &str = LightWay::Fullscreen.name();
pub const VOLUMES: &str = LightWay::Volumes.name();
pub const STENCIL: &str = LightWay::Stencil.name();
pub const CLUSTERS: &str = LightWay::Clusters.name();
pub const LIGHT_WAYS: [&str; 4] = [FULLSCREEN, VOLUMES, STENCIL, CLUSTERS];
pub const PREPASS: &str = "forward, depth pre-pass";
/// Every light draws every object in view.
pub const WITHOUT_SETS: &str = "forward-multipass without sets";
/// The floating light's scene without that light.
pub const WITHOUT: &str = "without the light";

/// The rows of a table.
pub fn cases(name: TableName, device: &Device, settings: &Settings) -> Result<Vec<Case>> {
    let s = settings;
    Ok(match name {
        TableName::Exterior => by_size(scenes::exterior()?, s),
        TableName::Interior => by_size(scenes::interior()?, s),
        TableName::Draws => draws(s)?,
        TableName::Coverage => coverage(device, s)?,
        TableName::Floating => floating(s),
        TableName::Sets => {
            let scene = Rc::new(scenes::interior()?);
            let with = way(MULTIPASS, &scene, Path::ForwardMultipass, LightWay::Auto);
            let mut without = way(WITHOUT_SETS, &scene, Path::ForwardMultipass, LightWay::Auto);
            without.options.illumination_sets = false;
            let ways = vec![with, without];
            vec![Case { label: "interior".into(), x: 0.0, size: s.view_size, ways, stages: false }]
        }
        TableName::Lights => {
            let counts = places(s, 1, s.most_lights);
            let case = |n: usize| Ok(lights_case(scenes::many_lights(n)?, n as f64, format!("{n}"), s, true));
            counts.into_iter().map(case).collect::<Result<_>>()?
        }
        TableName::Small => {
            let case = |n: usize| {
                lights_case(scenes::small_lights(n, aspect(s.sweep_size)), n as f64, format!("{n}"), s, false)
            };
            places(s, 1, s.most_lights.min(256)).into_iter().map(case).collect()
        }
        TableName::Overlap => {
            let case = |quarters: usize| {
                let overlap = quarters as f32 / 4.0;
                let scene = scenes::overlapping_lights(overlap, aspect(s.sweep_size));
                lights_case(scene, f64::from(overlap), format!("{overlap}"), s, true)
            };
            places(s, 1, 64).into_iter().map(case).collect()
        }
        TableName::Overdraw => {
            let case = |n: usize| {
                let scene = Rc::new(scenes::layers(n));
                let ways = paths(&scene);
                Case { label: format!("{n}"), x: n as f64, size: s.sweep_size, ways, stages: false }
            };
            places(s, 1, 16).into_iter().map(case).collect()
        }
    })
}

fn aspect([width, height]: [u32; 2]) -> f32 {
    width as f32 / height as f32
}

/// `first`, and its multiples by powers of 4 up to `last`, which is the end in any case; by powers of 16 if quick.
fn places(settings: &Settings, first: usize, last: usize) -> Vec<usize> {
    let factor = if settings.quick { 16 } else { 4 };
    let mut places: Vec<_> =
        std::iter::successors(Some(first), |n| Some(n * factor)).take_while(|n| *n < last).collect();
    places.push(last);
    places
}

fn way(name: &str, scene: &Rc<Scene>, path: Path, lights: LightWay) -> Way {
    Way { name: name.into(), scene: scene.clone(), options: Options { path, lights, ..Options::default() } }
}

/// Deferred as `auto` lights it, and all kinds of forward.
fn paths(scene: &Rc<Scene>) -> Vec<Way> {
    let path = |path: Path| way(path.name(), scene, path, LightWay::Auto);
    let mut prepass = way(PREPASS, scene, Path::Forward, LightWay::Auto);
    prepass.options.depth_prepass = true;
    vec![path(Path::Deferred), path(Path::Forward), prepass, path(Path::ForwardMultipass)]
}

/// The ways of lights, deferred.
fn light_ways(scene: &Rc<Scene>) -> Vec<Way> {
    [LightWay::Fullscreen, LightWay::Volumes, LightWay::Stencil, LightWay::Clusters]
        .map(|lights| way(lights.name(), scene, Path::Deferred, lights))
        .into()
}

fn by_size(scene: Scene, settings: &Settings) -> Vec<Case> {
    let scene = Rc::new(scene);
    let case = |&[width, height]: &[u32; 2]| Case {
        label: format!("{width} x {height}"),
        x: f64::from(width) * f64::from(height) * 1e-6,
        size: [width, height],
        ways: paths(&scene),
        // Of the largest.
        stages: settings.sizes.last() == Some(&[width, height]),
    };
    settings.sizes.iter().map(case).collect()
}

fn draws(settings: &Settings) -> Result<Vec<Case>> {
    let (exterior, interior) = (scenes::exterior()?, scenes::interior()?);
    let rows = [
        ("exterior", exterior),
        ("interior, shadows on", interior.clone()),
        ("interior, shadows off", interior.without_shadows()),
    ];
    let case = |(i, (label, scene)): (usize, (&str, Scene))| Case {
        label: label.into(),
        x: i as f64,
        size: settings.view_size,
        ways: paths(&Rc::new(scene)),
        stages: false,
    };
    Ok(rows.into_iter().enumerate().map(case).collect())
}

fn coverage(device: &Device, settings: &Settings) -> Result<Vec<Case>> {
    let rows =
        [("one spot", 1, false), ("one spot", 1, true), ("two spots", 2, false), ("two spots", 2, true)];
    let case = |(i, (label, count, close)): (usize, (&str, usize, bool))| {
        let scene = scenes::spots(count, close);
        let share = lit_share(device, &scene, settings.view_size)?;
        Ok(Case {
            label: format!("{label}, {:.0} % of the screen", share * 100.0),
            x: i as f64,
            size: settings.view_size,
            ways: paths(&Rc::new(scene)),
            stages: false,
        })
    };
    rows.into_iter().enumerate().map(case).collect()
}

fn floating(settings: &Settings) -> Vec<Case> {
    let [without, with] = [false, true].map(|floating| Rc::new(scenes::floating(floating)));
    let pairs =
        [LightWay::Fullscreen, LightWay::Volumes, LightWay::Stencil, LightWay::Clusters].map(|lights| {
            let name = lights.name();
            [
                way(name, &with, Path::Deferred, lights),
                way(&format!("{name}, {WITHOUT}"), &without, Path::Deferred, lights),
            ]
        });
    vec![Case {
        label: "a floating spot".into(),
        x: 0.0,
        size: settings.view_size,
        ways: pairs.into_iter().flatten().collect(),
        stages: false,
    }]
}

/// The ways of lights and, if wanted, the forward paths.
fn lights_case(scene: Scene, x: f64, label: String, settings: &Settings, forward: bool) -> Case {
    let scene = Rc::new(scene);
    let mut ways = light_ways(&scene);
    if forward {
        ways.extend(paths(&scene).into_iter().skip(1));
    }
    Case { label, x, size: settings.sweep_size, ways, stages: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_end_where_they_are_told_to() {
        let settings = |quick| Settings {
            sizes: vec![],
            view_size: [4, 3],
            sweep_size: [16, 9],
            most_lights: 1024,
            quick,
        };
        assert_eq!(places(&settings(false), 1, 1024), [1, 4, 16, 64, 256, 1024]);
        assert_eq!(places(&settings(false), 1, 100), [1, 4, 16, 64, 100]);
        assert_eq!(places(&settings(true), 1, 256), [1, 16, 256]);
        assert_eq!(places(&settings(true), 1, 1), [1]);
    }
}
