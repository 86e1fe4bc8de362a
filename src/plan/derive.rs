//! From stages to passes: which resources share an attachment, which stages share a pass, what is loaded and
//! stored, and which dependencies order it all. Nothing here is typed in by hand; it follows from `Stage::uses`.

mod cover;
mod outside;

use std::collections::BTreeMap;

use super::access::{Access, Scope, State};
pub(super) use outside::Order;
use outside::{after_frame, order_after_outside, order_before_outside};

use super::rendering::{self, Rendered};
use super::stage::{Frame, Resource, Stage, Use};
use super::{
    Attachment, Dependency, Load, Options, Pass, PassAttachment, Resolve, SampledAttachment, Store, Strategy,
    Subpass, Usage,
};

/// Places resources in attachments, as a compiler allocates registers: a resource may take over an attachment of
/// the same format and samples once the previous occupant was last read in an earlier stage.
///
/// The final image is placed first and can take in earlier resources only if it may be read as an input
/// attachment. A resource that must be cleared can only be the first occupant, because an attachment is cleared
/// when its pass begins. Returns, for each attachment, its resources in order of lifetime.
pub fn place(frame: &Frame, options: &Options) -> Vec<Vec<usize>> {
    let mut places: Vec<Vec<usize>> = Vec::new();
    for resource in 0..frame.resources.len() {
        let fits = |place: &Vec<usize>| {
            let mut all = place.clone();
            all.push(resource);
            options.recycle && can_share(frame, options, &mut all)
        };
        match places.iter().position(fits) {
            Some(p) => places[p].push(resource),
            None => places.push(vec![resource]),
        }
    }
    for place in &mut places {
        place.sort_by_key(|&r| frame.lifetime(r));
    }
    places
}

fn can_share(frame: &Frame, options: &Options, all: &mut [usize]) -> bool {
    all.sort_by_key(|&r| frame.lifetime(r));
    let like = |r: usize| (frame.resources[r].format, frame.resources[r].samples);
    let reads_output = all.contains(&Frame::OUTPUT) && !options.output_is_input_attachment;
    !reads_output
        && all.iter().all(|&r| like(r) == like(all[0]))
        && all.iter().skip(1).all(|&r| frame.resources[r].clear.is_none())
        && all.windows(2).all(|w| frame.lifetime(w[0]).1 < frame.lifetime(w[1]).0)
}

/// Uses as a colour output.
const OUTPUTS: &[Use] = &[Use::Write, Use::Blend, Use::Modify, Use::Rewrite];
/// Uses as an input attachment.
const INPUTS: &[Use] = &[Use::Read, Use::Modify, Use::Rewrite];

/// How one pass touches one attachment, in order of stages.
struct Touch {
    subpass: usize,
    resource: usize,
    uses: Vec<Use>,
}

impl Touch {
    fn writes(&self) -> bool {
        self.uses.iter().any(|how| how.writes())
    }
}

/// Groups stages into passes and derives every operation.
pub fn passes(frame: &Frame, places: &[Vec<usize>], options: &Options, strategy: Strategy) -> Vec<Pass> {
    let groups = groups(frame, strategy);
    let place_of = |resource| places.iter().position(|p| p.contains(&resource)).unwrap_or(0);
    let mut states: BTreeMap<usize, State> = BTreeMap::new();
    let is_rendering = strategy == Strategy::LocalRead;
    groups.iter().map(|stages| pass(frame, options, stages, is_rendering, &place_of, &mut states)).collect()
}

/// The stages of each pass: merged, all up to one that samples what another of them has as an attachment.
fn groups(frame: &Frame, strategy: Strategy) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, stage) in frame.stages.iter().enumerate() {
        let attached_by = |s: &usize, resource| {
            frame.stages[*s].uses.iter().any(|&(r, how)| r == resource && how != Use::Sample)
        };
        let follows = |group: &&mut Vec<usize>| {
            let mut sampled = stage.uses.iter().filter(|(_, how)| *how == Use::Sample);
            strategy.is_merged() && !sampled.any(|&(r, _)| group.iter().any(|s| attached_by(s, r)))
        };
        match groups.last_mut().filter(follows) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups
}

fn pass(
    frame: &Frame,
    options: &Options,
    stages: &[usize],
    is_rendering: bool,
    place_of: &dyn Fn(usize) -> usize,
    states: &mut BTreeMap<usize, State>,
) -> Pass {
    let mut touches: BTreeMap<usize, Vec<Touch>> = BTreeMap::new();
    for (subpass, &stage) in stages.iter().enumerate() {
        // What is sampled is no attachment of the pass.
        for &(resource, how) in frame.stages[stage].uses.iter().filter(|(_, how)| *how != Use::Sample) {
            let of_attachment = touches.entry(place_of(resource)).or_default();
            match of_attachment.last_mut() {
                Some(touch) if touch.subpass == subpass => touch.uses.push(how),
                _ => of_attachment.push(Touch { subpass, resource, uses: vec![how] }),
            }
        }
    }
    let [first_stage, last_stage] = [stages[0], stages[stages.len() - 1]];
    let mut dependencies = Dependencies::default();
    let mut attachments = Vec::new();
    let mut rendered = Vec::new();
    for (&attachment, touches) in &touches {
        let [first, last] = [&touches[0], &touches[touches.len() - 1]];
        let depth = frame.resources[first.resource].format.is_depth();
        let written_before = frame.lifetime(first.resource).0 < first_stage;
        let load = match frame.resources[first.resource].clear {
            _ if written_before => Load::Load,
            Some(_) => Load::Clear,
            None => Load::DontCare,
        };
        let used_later = {
            let Resource { kept, sampled, .. } = frame.resources[last.resource];
            kept || sampled || frame.lifetime(last.resource).1 > last_stage
        };
        let store = if used_later { Store::Store } else { Store::DontCare };

        let placed = frame.resources.iter().enumerate().filter(|(r, _)| place_of(*r) == attachment);
        let host: Scope = placed.flat_map(|(r, _)| after_frame(frame, options, r)).collect();
        // Later passes of a frame wait for its first one.
        let earlier_host = if states.contains_key(&attachment) { Scope::new() } else { host.clone() };
        let state_before = states.get(&attachment).copied().unwrap_or(State::Undefined);
        let uses: Vec<_> = touches.iter().flat_map(|t| &t.uses).copied().collect();
        let during = State::throughout(&uses, depth);
        let is_last = || {
            let uses = |s: &Stage| s.uses.iter().any(|(r, _)| place_of(*r) == attachment);
            !frame.stages[last_stage + 1..].iter().any(uses)
        };
        let sampled_by =
            |s: &Stage| s.uses.iter().any(|&(r, how)| how == Use::Sample && place_of(r) == attachment);
        let next = || {
            let mut later = frame.stages[last_stage + 1..].iter().map(|s| s.uses.iter());
            let of_this = |(r, _): &&(usize, Use)| place_of(*r) == attachment;
            later.find_map(|uses| Some(uses.filter(of_this).collect::<Vec<_>>()).filter(|u| !u.is_empty()))
        };
        let next_samples = next().is_some_and(|uses| uses.iter().all(|(_, how)| *how == Use::Sample));
        let is_copied = frame.resources[last.resource].kept && last_stage + 1 == frame.stages.len();
        let is_output = last.resource == Frame::OUTPUT;
        let after = if next_samples || (frame.resources[last.resource].sampled && is_last()) {
            State::Sampled
        } else if is_output {
            State::after_frame(options.output_use)
        } else if is_copied {
            State::CopySource
        } else if is_rendering {
            during
        } else {
            State::of(&last.uses, depth)
        };
        states.insert(attachment, after);
        let is_kept = options.output_is_kept && attachment == place_of(Frame::OUTPUT);
        let outside = if frame.resources[last.resource].sampled {
            Some((Access::SampledRead, "passes after the frame's own sample it"))
        } else {
            let host = Access::after_frame(options.output_use).filter(|_| is_output);
            host.map(|access| (access, "the host uses the output"))
        };

        dependencies.order_within(frame, touches, depth);
        let mut earlier = earlier_host;
        earlier.extend(frame.stages.iter().any(sampled_by).then_some(Access::SampledRead));
        let before = order_after_outside(first, touches.len() == 1, depth, load, earlier);
        let later = order_before_outside(depth, store, outside, next_samples);
        if is_rendering {
            rendered.push(Rendered { during, before, after: later.map(|(order, _)| order) });
        } else {
            let why = "attachments are used by earlier passes and frames".to_owned();
            dependencies.add(None, Some(first.subpass), before, why);
            if let Some((order, why)) = later {
                dependencies.add(Some(last.subpass), None, order, why.to_owned());
            }
        }
        attachments.push(PassAttachment {
            attachment,
            load,
            store,
            stencil: stencil(frame, first.resource, stages),
            initial: match load {
                Load::Load => state_before,
                // Whatever stays was left in this state.
                _ if is_kept && state_before == State::Undefined => State::after_frame(options.output_use),
                _ if is_kept => state_before,
                _ => State::Undefined,
            },
            last: after,
        });
    }
    for touches in touches.values() {
        let depth = frame.resources[touches[0].resource].format.is_depth();
        let alternates = [super::stage::PEEL, super::stage::MEDIA, super::stage::PARTICLES];
        let alternates = frame.stages.iter().any(|stage| alternates.contains(&stage.name));
        dependencies.cover(touches, depth, alternates);
        if !is_rendering {
            dependencies.rearrange(frame, touches, depth);
        }
    }
    let index_of =
        |resource| attachments.iter().position(|a| a.attachment == place_of(resource)).unwrap_or(0);
    let subpasses = stages
        .iter()
        .enumerate()
        .map(|(index, &stage)| subpass(frame, stage, index, &touches, &attachments, (&index_of, place_of)))
        .collect();
    let pass = Pass {
        name: stages.iter().map(|&s| frame.stages[s].name).collect::<Vec<_>>().join("+"),
        attachments,
        subpasses,
        dependencies: dependencies.finish(),
        enter: Vec::new(),
        leave: Vec::new(),
    };
    let held = |attachment| {
        let resource = &frame.resources[touches[&attachment][0].resource];
        (resource.format.is_depth(), resource.format.bits() * resource.samples)
    };
    if is_rendering { rendering::of(pass, rendered, &held) } else { pass }
}

/// What becomes of a resource's stencil in a pass: it is cleared when it is first used, and forgotten after the last use.
fn stencil(frame: &Frame, resource: usize, stages: &[usize]) -> (Load, Store) {
    let uses = |s: &usize| frame.stages[*s].uses.contains(&(resource, Use::Stencil));
    let all: Vec<_> = (0..frame.stages.len()).filter(uses).collect();
    if !stages.iter().any(uses) {
        return (Load::DontCare, Store::DontCare);
    }
    let load = if all.iter().any(|s| *s < stages[0]) { Load::Load } else { Load::Clear };
    let used_later = all.iter().any(|s| *s > stages[stages.len() - 1]);
    (load, if used_later { Store::Store } else { Store::DontCare })
}

fn subpass(
    frame: &Frame,
    stage: usize,
    index: usize,
    touches: &BTreeMap<usize, Vec<Touch>>,
    attachments: &[PassAttachment],
    (index_of, place_of): (&dyn Fn(usize) -> usize, &dyn Fn(usize) -> usize),
) -> Subpass {
    let clears = frame.clears.iter().filter(|(s, ..)| *s == stage);
    let clears = clears.map(|&(_, resource, value)| (index_of(resource), value)).collect();
    let stage = &frame.stages[stage];
    let of = |wanted: &[Use]| -> Vec<usize> {
        stage.uses.iter().filter(|(_, how)| wanted.contains(how)).map(|(r, _)| index_of(*r)).collect()
    };
    let names = |wanted: &[Use]| -> Vec<&'static str> {
        let uses = stage.uses.iter().filter(|(_, how)| wanted.contains(how));
        uses.map(|(r, _)| frame.resources[*r].name).collect()
    };
    let state = |i: usize| {
        let touch = touches[&attachments[i].attachment].iter().find(|t| t.subpass == index);
        let is_depth = |t: &Touch| frame.resources[t.resource].format.is_depth();
        touch.map_or(State::Undefined, |t| State::of(&t.uses, is_depth(t)))
    };
    let depth = of(&[Use::Depth, Use::DepthTest, Use::Stencil]).first().copied();
    // Live here: used at or after its first touch, up to its last one or, when stored, to the end of the pass.
    let alive = |a: &PassAttachment| {
        let touches = &touches[&a.attachment];
        let until = if a.store == Store::Store { usize::MAX } else { touches[touches.len() - 1].subpass };
        let since = if a.load == Load::DontCare { touches[0].subpass } else { 0 };
        (since..=until).contains(&index)
    };
    let unused_here = |a: &PassAttachment| touches[&a.attachment].iter().all(|t| t.subpass != index);
    let live: Vec<_> = (0..attachments.len()).filter(|&i| alive(&attachments[i])).collect();
    let bits = |depth: bool| {
        let touches = live.iter().map(|&i| &touches[&attachments[i].attachment]);
        // What samples are resolved to leaves the tile as it is made.
        let held = touches.filter(|touches| touches.iter().any(|t| t.uses != [Use::Resolve]));
        let resources = held.map(|touches| &frame.resources[touches[0].resource]);
        resources.filter(|r| r.format.is_depth() == depth).map(|r| r.format.bits() * r.samples).sum()
    };
    let resolve = stage.uses.iter().position(|(_, how)| *how == Use::Resolve).map(|at| {
        let before = stage.uses[..at].iter().filter(|(_, how)| OUTPUTS.contains(how));
        let to = index_of(stage.uses[at].0);
        Resolve { from: before.count().saturating_sub(1), to, state: state(to) }
    });
    let sampled = stage.uses.iter().filter(|(_, how)| *how == Use::Sample).map(|&(resource, _)| {
        SampledAttachment { name: frame.resources[resource].name, attachment: place_of(resource) }
    });
    Subpass {
        name: stage.name,
        why: stage.why.clone(),
        color_names: names(OUTPUTS),
        colors: of(OUTPUTS),
        blend: stage.uses.iter().any(|(_, how)| *how == Use::Blend),
        ordered: stage.uses.iter().any(|(_, how)| *how == Use::Modify),
        barriers: stage.uses.iter().any(|(_, how)| *how == Use::Rewrite),
        color_states: of(OUTPUTS).iter().map(|&i| state(i)).collect(),
        resolve,
        input_names: names(INPUTS),
        input_states: of(INPUTS).iter().map(|&i| state(i)).collect(),
        inputs: of(INPUTS),
        samples: sampled.collect(),
        depth_state: depth.map(state),
        depth,
        tests_peeled: names(&[Use::DepthTest]).iter().any(|name| name.starts_with("peel")),
        depth_write: stage.uses.iter().any(|(_, how)| *how == Use::Depth),
        stencil: stage.uses.iter().any(|(_, how)| *how == Use::Stencil),
        clears,
        preserve: live.iter().copied().filter(|&i| unused_here(&attachments[i])).collect(),
        live_color_bits: bits(false),
        live_depth_bits: bits(true),
    }
}

/// Collects dependencies; one per pair of subpasses.
#[derive(Default)]
struct Dependencies(BTreeMap<(Option<usize>, Option<usize>), Dependency>);

impl Dependencies {
    fn add(&mut self, from: Option<usize>, to: Option<usize>, (before, after): Order, why: String) {
        let entry = self.0.entry((from, to)).or_insert_with(|| Dependency {
            from,
            to,
            before: Scope::default(),
            after: Scope::default(),
            // Every read is of the reader's own pixel, so a tile never waits for another one.
            by_region: from.is_some() && to.is_some(),
            why: Vec::new(),
        });
        entry.before.extend(before);
        entry.after.extend(after);
        entry.why.push(why);
    }

    /// Reads wait for the last write, writes for that and for the reads since. The store at the end of the pass, even one
    /// that discards, counts as a write by the last subpass that touches the attachment, so that write is ordered too.
    fn order_within(&mut self, frame: &Frame, touches: &[Touch], depth: bool) {
        for (index, b) in touches.iter().enumerate() {
            if b.uses.contains(&Use::Rewrite) {
                let why = format!(
                    "{} is written by one draw, then read by another over it",
                    frame.resources[b.resource].name
                );
                let [before, after] = Access::BETWEEN_DRAWS.map(|access| [access].into());
                self.add(Some(b.subpass), Some(b.subpass), (before, after), why);
            }
            let is_last = index + 1 == touches.len();
            let written = touches[..index].iter().rposition(Touch::writes);
            let reads = &touches[written.map_or(0, |w| w + 1)..index];
            // A write that follows reads is ordered after the earlier write by them.
            let written = written.filter(|_| !b.writes() || reads.is_empty()).map(|w| &touches[w]);
            let reads = reads.iter().filter(|_| b.writes() || is_last);
            for a in written.into_iter().chain(reads) {
                let mut after = Access::of(&b.uses);
                if is_last {
                    after.insert(Access::store(depth));
                }
                let names = [a.resource, b.resource].map(|r| frame.resources[r].name);
                let why = match (a.writes(), b.writes()) {
                    (true, false) => format!("{} is written, then read", names[0]),
                    (true, true) if b.uses.iter().any(|how| INPUTS.contains(how)) => {
                        format!("{} is written, then read and rewritten", names[0])
                    }
                    (true, true) => format!("{} is written, then added to", names[0]),
                    (false, true) => format!("{} is read, then overwritten by {}", names[0], names[1]),
                    (false, false) => format!("{} is read twice, then dropped or stored", names[0]),
                };
                self.add(Some(a.subpass), Some(b.subpass), (Access::of(&a.uses), after), why);
            }
        }
    }

    fn finish(self) -> Vec<Dependency> {
        let mut all: Vec<_> = self.0.into_values().collect();
        for d in &mut all {
            d.why.sort();
            d.why.dedup();
        }
        all
    }
}

/// Describes the attachments that resources were placed in.
pub fn attachments(
    frame: &Frame,
    places: &[Vec<usize>],
    passes: &[Pass],
    options: &Options,
) -> Vec<Attachment> {
    let describe = |(index, place): (usize, &Vec<usize>)| {
        let resources = place.iter().map(|&r| &frame.resources[r]);
        let uses: Vec<_> =
            frame.stages.iter().flat_map(|s| &s.uses).filter(|(r, _)| place.contains(r)).collect();
        let has = |wanted: &[Use]| uses.iter().any(|(_, how)| wanted.contains(how));
        let is_output = place.contains(&Frame::OUTPUT) && !options.edge_filter;
        let kept = place.iter().any(|&r| r != Frame::OUTPUT && frame.resources[r].kept);
        let in_passes = || passes.iter().flat_map(|p| &p.attachments).filter(|a| a.attachment == index);
        Attachment {
            name: resources.clone().map(|r| r.name).collect::<Vec<_>>().join("/"),
            format: frame.resources[place[0]].format,
            samples: frame.resources[place[0]].samples,
            holds: resources.clone().map(|r| r.holds).collect(),
            clear: frame.resources[place[0]].clear,
            is_output,
            transient: !is_output && in_passes().all(|a| a.load != Load::Load && a.store != Store::Store),
            usage: Usage {
                color: has(OUTPUTS) || has(&[Use::Resolve]),
                depth: has(&[Use::Depth, Use::DepthTest, Use::Stencil]),
                input: has(INPUTS),
                sampled: resources.clone().any(|r| r.sampled)
                    || has(&[Use::Sample])
                    || (is_output && options.output_use == super::OutputUse::Sample),
                copy_source: if is_output { options.output_use == super::OutputUse::Copy } else { kept },
                blend: has(&[Use::Blend]),
            },
            lifetime: (frame.lifetime(place[0]).0, frame.lifetime(place[place.len() - 1]).1),
            why: resources.map(|r| r.why.clone()).collect(),
        }
    };
    places.iter().enumerate().map(describe).collect()
}
