//! A plan for people.

use std::fmt::{Display, Formatter, Result};

use super::needs::element;
use super::{Load, Pass, Path, Plan, Store, Strategy, Transition, stage, verdicts};
use crate::visible::ShadowShape;

impl Display for Plan {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let o = &self.options;
        let [width, height] = o.size;
        write!(f, "plan: {width}x{height}, strategy {}, ", self.strategy)?;
        match self.path {
            Path::Deferred => writeln!(f, "layout {} ({})", o.layout, o.layout.source())?,
            path => writeln!(f, "path {path}")?,
        }
        for note in &self.notes {
            writeln!(f, "  - {note}")?;
        }
        self.print_attachments(f)?;
        self.print_poses(f)?;
        self.print_shadow_map(f)?;
        for (index, pass) in self.passes.iter().enumerate() {
            self.print_pass(f, index, pass)?;
        }
        writeln!(f, "\npipelines: {}", self.pipelines.len())?;
        for (stage, pipeline) in &self.pipelines {
            writeln!(f, "  {:<10} {}", self.subpass(*stage).2.name, self.pipeline_text(pipeline))?;
        }
        self.print_around(f)?;
        self.print_ledger(f)
    }
}

impl Plan {
    fn is_local_read(&self) -> bool {
        self.strategy == Strategy::LocalRead
    }

    fn pass_word(&self) -> &'static str {
        if self.is_local_read() { "rendering" } else { "render pass" }
    }

    fn stage_word(&self) -> &'static str {
        if self.is_local_read() { "stage" } else { "subpass" }
    }

    fn print_attachments(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "\nattachments: {}", self.attachments.len())?;
        for a in &self.attachments {
            let place = match (a.is_output, a.transient) {
                (true, _) => "host's image",
                (_, true) => "transient",
                _ => "in memory",
            };
            let (first, last) = a.lifetime;
            let stages = [first, last].map(|s| self.subpass(s).2.name);
            writeln!(
                f,
                "  {:<22} {:<11} {:>3} bits{}  {place:<12}  {}..{}",
                a.name,
                a.format,
                a.format.bits(),
                if a.samples > 1 { format!(" x{}", a.samples) } else { String::new() },
                stages[0],
                stages[1]
            )?;
            for (holds, why) in a.holds.iter().zip(&a.why) {
                writeln!(f, "      {holds}; {why}")?;
            }
        }
        Ok(())
    }

    fn print_poses(&self, f: &mut Formatter<'_>) -> Result {
        let Some(need) = &self.needs.posed else { return Ok(()) };
        writeln!(f, "\nposes: {}", need.why)?;
        writeln!(
            f,
            "  {}, {}, {}, {}",
            count(need.meshes, "mesh", "es"),
            match need.vertices {
                1 => "1 vertex".into(),
                n => format!("{n} vertices"),
            },
            count(need.joints, "joint", "s"),
            count(need.targets, "morph target", "s")
        )?;
        writeln!(
            f,
            "  by compute before all passes, where a pose has changed: at most {} bytes read and {} written; each pass, and each \
             tile of the shadow map, then draws them as what stands still",
            need.read_bytes, need.written_bytes
        )
    }

    fn print_shadow_map(&self, f: &mut Formatter<'_>) -> Result {
        let Some(map) = &self.shadow_map else { return Ok(()) };
        let [width, height] = map.size;
        writeln!(
            f,
            "\nshadow map: {width}x{height} texels of {}, {} bytes, {}",
            map.format,
            map.bytes(),
            count(map.tiles.len(), "tile", "s")
        )?;
        if map.has_static_map {
            writeln!(
                f,
                "  half of it is the static map: where only dynamic casters have moved, that part of a tile begins as a \
                 copy of what stands still, and only they are drawn"
            )?;
        }
        writeln!(
            f,
            "  a tile is a render pass before the others when what it shows has changed: cleared, stored once"
        )?;
        for light in &map.lights {
            let side = light.size.texels;
            let bytes: u64 = light.tiles.clone().map(|tile| map.tile_bytes(tile)).sum();
            writeln!(
                f,
                "  {}: {} of {side}x{side}, {bytes} bytes stored when drawn",
                element("light", &light.name, light.light),
                match light.shape {
                    ShadowShape::Cascades => count(light.tiles.len(), "cascade", "s"),
                    ShadowShape::Slab => "1 parallel view".into(),
                    ShadowShape::Cone => "1 view".into(),
                    ShadowShape::Cube => count(light.tiles.len(), "face", "s"),
                },
            )?;
        }
        map.casters.iter().try_for_each(|kind| writeln!(f, "  casters: {kind}"))
    }

    fn print_pass(&self, f: &mut Formatter<'_>, index: usize, pass: &Pass) -> Result {
        writeln!(f, "\n{} {index}: {}", self.pass_word(), pass.name)?;
        let name = |i: usize| self.attachments[pass.attachments[i].attachment].name.as_str();
        let load = |load: Load| match load {
            Load::Load => "LOAD",
            Load::Clear => "clear",
            Load::DontCare => "don't care",
        };
        let store = |store: Store| match store {
            Store::Store => "STORE",
            Store::DontCare => "don't care",
        };
        for (i, a) in pass.attachments.iter().enumerate() {
            writeln!(
                f,
                "  {:<22} load {:<10}  store {:<10}  {:?} -> {:?}",
                name(i),
                load(a.load),
                store(a.store),
                a.initial,
                a.last
            )?;
            if self.attachments[a.attachment].format.has_stencil() {
                let (first, last) = a.stencil;
                writeln!(f, "  {:<22} load {:<10}  store {:<10}", "  its stencil", load(first), store(last))?;
            }
        }
        let barriers = |f: &mut Formatter<'_>, when: &str, all: &[Transition]| {
            all.iter().try_for_each(|t| {
                let (from, to) = (t.from, t.to);
                let what = name(t.attachment);
                writeln!(f, "  barrier {when}, {what}: {from:?} -> {to:?}, {:?} -> {:?}", t.before, t.after)
            })
        };
        barriers(f, "before", &pass.enter)?;
        for (i, s) in pass.subpasses.iter().enumerate() {
            let list = |l: &[usize]| l.iter().map(|&i| name(i)).collect::<Vec<_>>().join(", ");
            writeln!(f, "  {} {i} {}: {}", self.stage_word(), s.name, s.why)?;
            if !s.clears.is_empty() {
                let cleared: Vec<_> = s.clears.iter().map(|(i, _)| *i).collect();
                writeln!(f, "      clears  {}", list(&cleared))?;
            }
            if !s.samples.is_empty() {
                let sampled = s.samples.iter().map(|s| self.attachments[s.attachment].name.as_str());
                writeln!(f, "      samples {}", sampled.collect::<Vec<_>>().join(", "))?;
            }
            if !s.inputs.is_empty() {
                writeln!(f, "      reads   {}", list(&s.inputs))?;
            }
            let blend = match (s.blend, s.ordered, s.barriers) {
                (true, ..) if s.name == "decals" => " (mixed)",
                (true, ..) if [stage::TRANSLUCENCY, stage::FOG].contains(&s.name) => " (blended)",
                (true, ..) if s.name == stage::MEDIA => " (multiplied, then added)",
                (true, ..) => " (added)",
                (_, true, _) => " (each fragment over what it has read, in order)",
                (_, _, true) => " (over what is read, with barriers between draws that overlap)",
                _ => "",
            };
            if !s.colors.is_empty() {
                writeln!(f, "      writes  {}{blend}", list(&s.colors))?;
            }
            if let Some(resolve) = s.resolve {
                writeln!(f, "      resolves {} to {}", name(s.colors[resolve.from]), name(resolve.to))?;
            }
            if let Some(depth) = s.depth {
                let writes = match (s.depth_write, s.stencil) {
                    (true, _) => "",
                    (false, true) => " (writes stencil only)",
                    (false, false) => " (writes nothing)",
                };
                writeln!(f, "      tests   {}{writes}", name(depth))?;
            }
            writeln!(
                f,
                "      on tile {} colour + {} depth bits a pixel",
                s.live_color_bits, s.live_depth_bits
            )?;
        }
        barriers(f, "after", &pass.leave)?;
        let end = |s: Option<usize>| s.map_or("outside", |s| pass.subpasses[s].name);
        for d in &pass.dependencies {
            let region = if d.by_region { " by region" } else { "" };
            writeln!(
                f,
                "  dependency {} -> {}{region}: {:?} -> {:?}",
                end(d.from),
                end(d.to),
                d.before,
                d.after
            )?;
            for why in &d.why {
                writeln!(f, "      {why}")?;
            }
        }
        Ok(())
    }

    fn print_around(&self, f: &mut Formatter<'_>) -> Result {
        if self.around.is_empty() {
            return Ok(());
        }
        writeln!(f, "\nsampled for light from all around: {}", self.around.len())?;
        for image in &self.around {
            let [width, height] = image.size;
            let shape = match image.cubes {
                0 => String::new(),
                1 => "cube ".into(),
                cubes => format!("{cubes} cubes "),
            };
            let levels = if image.levels == 1 { String::new() } else { format!(", {} levels", image.levels) };
            let (name, format, bytes, why) = (image.name, image.format, image.bytes, &image.why);
            writeln!(f, "  {name:<10} {shape}{width}x{height}{levels}, {format}, {bytes} bytes; {why}")?;
        }
        Ok(())
    }

    fn print_ledger(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "\nledger (planned), bytes a pixel:      loaded  stored")?;
        let mut total = [0, 0];
        for (i, a) in self.attachments.iter().enumerate() {
            let [loaded, stored] = self.traffic(i);
            total = [total[0] + loaded, total[1] + stored];
            writeln!(f, "  {:<34} {loaded:>6}  {stored:>6}", a.name)?;
        }
        writeln!(f, "  {:<34} {:>6}  {:>6}", "total", total[0], total[1])?;
        let peak =
            self.passes.iter().flat_map(|p| &p.subpasses).map(|s| s.live_color_bits).max().unwrap_or(0);
        writeln!(
            f,
            "  {}, {}, at most {peak} colour bits live on the tile",
            count(self.passes.len(), self.pass_word(), if self.is_local_read() { "s" } else { "es" }),
            count(self.stage_count(), self.stage_word(), if self.is_local_read() { "s" } else { "es" })
        )?;
        self.print_refraction(f)?;
        if let Some(map) = &self.shadow_map {
            let stored: u64 = (0..map.tiles.len()).map(|tile| map.tile_bytes(tile)).sum();
            writeln!(
                f,
                "  shadows: before them up to {}, which store {stored} bytes in all, of {} bytes of memory",
                count(map.tiles.len(), "tile pass", "es"),
                map.bytes()
            )?;
        }
        self.print_post(f)?;
        writeln!(f, "\ntilers (modelled):")?;
        for v in verdicts(self) {
            writeln!(
                f,
                "  {:<8} {:<12} {}",
                v.family,
                if v.fits { "on tile" } else { "not on tile" },
                v.reason
            )?;
        }
        Ok(())
    }
}

/// A number of things, with their plural's ending.
fn count(number: usize, thing: &str, plural: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { plural })
}
