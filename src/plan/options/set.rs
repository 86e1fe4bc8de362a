//! Options by name, for interfaces that have no such types.

use std::str::FromStr;

use super::Options;
use crate::{Error, Result};

type Set = fn(&mut Options, &str) -> Result<(), String>;

fn read<T: FromStr<Err: ToString>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error: T::Err| {
        // Those of choices say what was typed.
        let told = error.to_string();
        if told.starts_with('\'') { told } else { format!("'{text}': {told}") }
    })
}

/// Reads a value into its place.
fn to<T: FromStr<Err: ToString>>(place: &mut T, text: &str) -> Result<(), String> {
    *place = read(text)?;
    Ok(())
}

/// Likewise where `auto` leaves it open.
fn to_some<T: FromStr<Err: ToString>>(place: &mut Option<T>, text: &str) -> Result<(), String> {
    *place = if text == "auto" { None } else { Some(read(text)?) };
    Ok(())
}

fn to_size(place: &mut [u32; 2], text: &str) -> Result<(), String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    *place = sides.ok_or_else(|| format!("'{text}' is not a size like 1280x720"))?;
    Ok(())
}

/// In the order of the struct.
const ALL: [(&str, Set); 42] = [
    ("size", |o, text| to_size(&mut o.size, text)),
    ("strategy", |o, text| to(&mut o.strategy, text)),
    ("layout", |o, text| to(&mut o.layout, text)),
    ("normals", |o, text| to_some(&mut o.normals, text)),
    ("gamma", |o, text| to_some(&mut o.gamma, text)),
    ("light-target", |o, text| to_some(&mut o.light_target, text)),
    ("depth", |o, text| to_some(&mut o.depth, text)),
    ("brdf", |o, text| to(&mut o.brdf, text)),
    ("path", |o, text| to(&mut o.path, text)),
    ("lights", |o, text| to(&mut o.lights, text)),
    ("shadow-filter", |o, text| to(&mut o.shadows.filter, text)),
    ("shadow-format", |o, text| to(&mut o.shadows.format, text)),
    ("shadow-map", |o, text| to(&mut o.shadows.most_texels, text)),
    ("shadow-tile", |o, text| to_some(&mut o.shadows.tile_texels, text)),
    ("cascades", |o, text| to(&mut o.shadows.cascades, text)),
    ("tonemap", |o, text| to(&mut o.tonemap, text)),
    ("output", |o, text| to(&mut o.output, text)),
    ("output-use", |o, text| to(&mut o.output_use, text)),
    ("output-is-input-attachment", |o, text| to(&mut o.output_is_input_attachment, text)),
    ("recycle", |o, text| to(&mut o.recycle, text)),
    ("fold", |o, text| to(&mut o.fold, text)),
    ("dither", |o, text| to(&mut o.dither, text)),
    ("depth-prepass", |o, text| to(&mut o.depth_prepass, text)),
    ("illumination-sets", |o, text| to(&mut o.illumination_sets, text)),
    ("keep-gbuffer", |o, text| to(&mut o.keep_gbuffer, text)),
    ("environment-format", |o, text| to(&mut o.environment_format, text)),
    ("lightmap-format", |o, text| to(&mut o.lightmap_format, text)),
    ("translucency", |o, text| to(&mut o.translucency, text)),
    ("translucency-layers", |o, text| to_some(&mut o.translucency_layers, text)),
    ("samples", |o, text| to(&mut o.samples, text)),
    ("edges", |o, text| to(&mut o.edges, text)),
    ("resolve", |o, text| to(&mut o.resolve, text)),
    ("decals", |o, text| to(&mut o.decals, text)),
    ("bloom", |o, text| to(&mut o.bloom, text)),
    ("bloom-strength", |o, text| to(&mut o.bloom_strength, text)),
    ("bloom-radius", |o, text| to(&mut o.bloom_radius, text)),
    ("edge-filter", |o, text| to(&mut o.edge_filter, text)),
    ("shadow-volumes", |o, text| to(&mut o.shadow_volumes, text)),
    ("refraction", |o, text| to(&mut o.refraction, text)),
    ("stable-cascades", |o, text| to(&mut o.shadows.stable, text)),
    ("overlay", |o, text| to(&mut o.overlay, text)),
    ("show", |o, text| to(&mut o.show, text)),
];

impl Options {
    /// Sets an option by the name that it has on the command line, to a value as it is typed there. What is on or off there takes
    /// `true` or `false` here, and what may be left open takes `auto`. Beyond those of the command line there are `output`,
    /// `output-use`, `output-is-input-attachment`, `keep-gbuffer`, `overlay` and `stable-cascades`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] that lists the names, or the values, that there are.
    pub fn set(&mut self, name: &str, value: &str) -> Result<()> {
        let Some((_, set)) = ALL.iter().find(|(known, _)| *known == name) else {
            let known = ALL.map(|(known, _)| known).join(", ");
            return Err(Error::unsupported(
                format!("there is no option '{name}'"),
                format!("use one of: {known}"),
            ));
        };
        set(self, value).map_err(|problem| {
            Error::unsupported(format!("option '{name}': {problem}"), "give a value of its kind")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, Normals, ShadowFilter};

    #[test]
    fn options_have_names() {
        let mut options = Options::default();
        let pairs = [
            ("size", "640x360"),
            ("layout", "packed128"),
            ("normals", "oct12"),
            ("shadow-filter", "jittered"),
            ("shadow-tile", "512"),
            ("fold", "false"),
            ("bloom-strength", "0.5"),
        ];
        pairs.iter().for_each(|(name, value)| options.set(name, value).unwrap());
        assert_eq!((options.size, options.layout), ([640, 360], Layout::Packed128));
        assert_eq!((options.normals, options.shadows.filter), (Some(Normals::Oct12), ShadowFilter::Jittered));
        assert_eq!((options.shadows.tile_texels, options.fold), (Some(512), false));
        options.set("normals", "auto").unwrap();
        assert_eq!(options.normals, None);
        for (name, value, what) in [
            ("lights", "many", "option 'lights': 'many' is not one of: fullscreen"),
            ("lamps", "1", "use one of: size, strategy"),
            ("size", "12", "'12' is not a size like 1280x720"),
            ("samples", "-1", "option 'samples': '-1'"),
        ] {
            let error = options.set(name, value).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
    }
}
