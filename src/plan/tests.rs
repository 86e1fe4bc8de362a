//! The derivation against a naive oracle: an interpreter that executes a derived plan on symbols and checks that
//! every stage finds what it must find, for random frames. Removing any one load, clear, store or dependency from a
//! plan must be noticed, so none is superfluous and the oracle is not blind.

use std::collections::BTreeMap;

use proptest::prelude::*;
use proptest::strategy::Strategy;

use super::access::Access;
use super::stage::{Frame, Resource, Stage, Use};
use super::*;

/// What a pixel of an attachment holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Garbage,
    Cleared,
    /// The n-th version of a resource.
    Version(usize, usize),
}

/// Executes the passes on symbols; `Err` says which stage found the wrong content.
fn interpret(frame: &Frame, places: &[Vec<usize>], passes: &[Pass]) -> std::result::Result<(), String> {
    let place_of = |r: usize| places.iter().position(|p| p.contains(&r)).unwrap();
    let mut memory = vec![Content::Garbage; places.len()];
    let mut versions = vec![0; frame.resources.len()];
    let mut stages = frame.stages.iter();
    for pass in passes {
        let mut tile = vec![Content::Garbage; places.len()];
        for a in &pass.attachments {
            tile[a.attachment] = match a.load {
                Load::Load => memory[a.attachment],
                Load::Clear => Content::Cleared,
                Load::DontCare => Content::Garbage,
            };
        }
        for _ in &pass.subpasses {
            let stage = stages.next().ok_or("more subpasses than stages")?;
            let (sampled, used): (Vec<_>, Vec<_>) =
                stage.uses.iter().partition(|(_, how)| *how == Use::Sample);
            for &(r, _) in sampled {
                if memory[place_of(r)] != Content::Version(r, versions[r]) {
                    return Err(format!("{} samples {:?}", stage.name, memory[place_of(r)]));
                }
                if pass.attachments.iter().any(|a| a.attachment == place_of(r)) {
                    return Err(format!("{} samples an attachment of its pass", stage.name));
                }
            }
            for &(r, how) in used {
                let cell = &mut tile[place_of(r)];
                let expected = match versions[r] {
                    0 => Content::Cleared,
                    n => Content::Version(r, n),
                };
                let first_partial_write = versions[r] == 0 && frame.resources[r].clear.is_some();
                let matters = how.reads() || how == Use::Depth || first_partial_write;
                if matters && *cell != expected {
                    return Err(format!("{} finds {cell:?} instead of {expected:?}", stage.name));
                }
                if how.writes() {
                    versions[r] += 1;
                    *cell = Content::Version(r, versions[r]);
                }
            }
        }
        for a in &pass.attachments {
            memory[a.attachment] = match a.store {
                Store::Store => tile[a.attachment],
                Store::DontCare => Content::Garbage,
            };
        }
    }
    for (r, _) in frame.resources.iter().enumerate().filter(|(_, resource)| resource.kept) {
        if memory[place_of(r)] != Content::Version(r, versions[r]) {
            return Err(format!("resource {r} is not in memory after the frame"));
        }
    }
    Ok(())
}

/// Checks that every conflict between two subpasses is ordered by a dependency whose scopes cover it.
fn check_dependencies(
    frame: &Frame,
    places: &[Vec<usize>],
    passes: &[Pass],
) -> std::result::Result<(), String> {
    let mut first_stage = 0;
    for pass in passes {
        for place in places {
            let uses_in = |s: usize| {
                let uses = frame.stages[first_stage + s].uses.iter();
                uses.filter(|(r, how)| place.contains(r) && *how != Use::Sample)
                    .map(|(_, how)| *how)
                    .collect::<Vec<_>>()
            };
            let users: Vec<_> = (0..pass.subpasses.len()).filter(|&s| !uses_in(s).is_empty()).collect();
            let writes = |s: usize| uses_in(s).into_iter().any(Use::writes);
            for (i, j) in
                users.iter().flat_map(|&i| users.iter().map(move |&j| (i, j))).filter(|(i, j)| i < j)
            {
                // The store at the end of the pass writes too. What lies between two users may order them already: a
                // write always does, a read does between two writes.
                let is_last = users.last() == Some(&j);
                let mut between = users.iter().filter(|&&k| i < k && k < j);
                let ordered = between.any(|&k| writes(k) || (writes(i) && writes(j)));
                // So does a change of layout between reads.
                let is_depth = frame.resources[place[0]].format.is_depth();
                let state = |s: usize| State::of(&uses_in(s), is_depth);
                let changes = pass.enter.is_empty() && state(i) != state(j);
                // And the change that the first of several reads begins with, for the others.
                let since = users.iter().rev().filter(|&&k| k <= j).take_while(|&&k| state(k) == state(j));
                let is_next = !users.iter().any(|&k| i < k && k < j);
                let settled = pass.enter.is_empty()
                    && is_next
                    && state(i) == state(j)
                    && since.copied().all(|k| !writes(k));
                if ordered || !(writes(i) || writes(j) || is_last || changes || settled) {
                    continue;
                }
                for (a, b) in uses_in(i).into_iter().flat_map(|a| uses_in(j).into_iter().map(move |b| (a, b)))
                {
                    let mut after = Access::of(&[b]);
                    if is_last {
                        after.insert(Access::store(frame.resources[place[0]].format.is_depth()));
                    }
                    let covered = pass.dependencies.iter().any(|d| {
                        (d.from, d.to) == (Some(i), Some(j))
                            && d.by_region
                            && d.before.is_superset(&Access::of(&[a]))
                            && d.after.is_superset(&after)
                    });
                    if !covered {
                        return Err(format!("{a:?} in {i}, then {b:?} in {j} is not ordered"));
                    }
                }
            }
        }
        first_stage += pass.subpasses.len();
    }
    Ok(())
}

prop_compose! {
    /// Up to 5 stages that use up to 6 resources in every legal way; the last stage writes the output. `samples`: from some stage on
    /// a resource may be sampled alone.
    fn frames(samples: bool)(
        stages in 1..=5_usize,
        resources in prop::collection::vec(
            (any::<[u8; 5]>(), any::<bool>(), any::<bool>(), any::<bool>(), 0..5_usize), 0..6),
        multisampled in any::<bool>(),
    ) -> Frame {
        let mut uses: BTreeMap<usize, Vec<(usize, Use)>> = BTreeMap::new();
        uses.entry(stages - 1).or_default().push((Frame::OUTPUT, Use::Write));
        let resource = |format, clear: bool, kept| Resource {
            name: "r", format, holds: "", samples: 1, clear: clear.then_some([0.0; 4]), kept,
            sampled: false, why: String::new(),
        };
        let mut all = vec![resource(Format::Rgba8Srgb, false, true)];
        for (how, clear, kept, wide, start) in resources {
            let r = all.len();
            let start = start.min(stages - 1);
            let is_depth = how[0] % 7 == 0;
            let format = match (is_depth, wide) {
                (true, _) => Format::D32Float,
                (_, true) => Format::Rgba16Float,
                _ => Format::Rgba8Srgb,
            };
            all.push(resource(format, clear || is_depth, kept && how[1] % 4 == 0));
            let sampled_from = start + 1 + usize::from(how[2] % 4);
            for stage in start..stages {
                let first = stage == start;
                if samples && how[0] % 2 == 0 && stage >= sampled_from {
                    uses.entry(stage).or_default().push((r, Use::Sample));
                    continue;
                }
                let how = match how[stage] % 7 {
                    1 if is_depth && !first => Use::DepthTest,
                    2 if is_depth && !first => continue,
                    3 if is_depth && !first => Use::Stencil,
                    4 if is_depth && !first => Use::Read,
                    5 if is_depth && !first => {
                        uses.entry(stage).or_default().push((r, Use::Read));
                        Use::DepthTest
                    }
                    _ if is_depth => Use::Depth,
                    _ if first && !clear => Use::Write,
                    0 if !first => Use::Read,
                    1 => Use::Blend,
                    2 if first => Use::Write,
                    3 if !first => continue,
                    4 => Use::Modify,
                    _ if first => Use::Write,
                    _ => Use::Read,
                };
                uses.entry(stage).or_default().push((r, how));
            }
        }
        let stage = |s| Stage { name: "s", uses: uses.remove(&s).unwrap_or_default(), why: String::new() };
        let mut frame = Frame { resources: all, stages: (0..stages).map(stage).collect(), folded: false, clears: Vec::new() };
        super::stage::multisample(&mut frame, if multisampled { 4 } else { 1 });
        frame
    }
}

fn options() -> impl Strategy<Value = Options> {
    use super::Strategy::{LocalRead, Separate, Subpasses};
    let strategy = prop::sample::select(&[Subpasses, Separate, LocalRead]);
    (strategy, any::<bool>(), any::<bool>()).prop_map(|(strategy, recycle, input)| Options {
        strategy,
        recycle,
        output_is_input_attachment: input,
        ..Options::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_stage_finds_what_it_needs_and_nothing_is_superfluous(frame in frames(true), options in options()) {
        let places = derive::place(&frame, &options);
        let passes = derive::passes(&frame, &places, &options, options.strategy);
        prop_assert_eq!(interpret(&frame, &places, &passes), Ok(()));
        prop_assert_eq!(check_dependencies(&frame, &places, &passes), Ok(()));

        let is_rendering = options.strategy == super::Strategy::LocalRead;
        for subpass in passes.iter().flat_map(|p| &p.subpasses) {
            let both = subpass.inputs.iter().zip(&subpass.input_states);
            for (input, state) in both {
                let color = subpass.colors.iter().position(|c| c == input);
                let expected = if is_rendering { State::LocalRead } else { State::InputColor };
                prop_assert_eq!(color.is_some() || is_rendering, *state == expected);
                prop_assert!(color.is_none_or(|c| subpass.color_states[c] == *state && subpass.ordered));
            }
        }
        for (p, pass) in passes.iter().enumerate() {
            for (a, attachment) in pass.attachments.iter().enumerate() {
                let mut broken = passes.clone();
                if attachment.load != Load::DontCare {
                    broken[p].attachments[a].load = Load::DontCare;
                    prop_assert!(interpret(&frame, &places, &broken).is_err(), "superfluous {:?}", attachment.load);
                }
                broken = passes.clone();
                if attachment.store == Store::Store {
                    broken[p].attachments[a].store = Store::DontCare;
                    prop_assert!(interpret(&frame, &places, &broken).is_err(), "superfluous store");
                }
            }
            for d in (0..pass.dependencies.len()).filter(|&d| pass.dependencies[d].by_region) {
                let mut broken = passes.clone();
                broken[p].dependencies.remove(d);
                prop_assert!(check_dependencies(&frame, &places, &broken).is_err(), "superfluous dependency");
            }
        }
    }

    #[test]
    fn the_hosts_image_is_written_only_after_the_host_has_used_it(frame in frames(false), options in options()) {
        let places = derive::place(&frame, &options);
        let passes = derive::passes(&frame, &places, &options, options.strategy);
        let host = Access::after_frame(options.output_use).unwrap();
        for (attachment, place) in places.iter().enumerate() {
            if !place.iter().any(|&r| frame.resources[r].kept) {
                continue;
            }
            // `Options::default` copies the output, as hosts copy a kept G-buffer.
            let first = passes.iter().position(|p| p.attachments.iter().any(|a| a.attachment == attachment));
            let first_stage: usize = passes[..first.unwrap()].iter().map(|p| p.subpasses.len()).sum();
            let uses = |s: usize| frame.stages[s].uses.iter().any(|(r, _)| place.contains(r));
            let subpass = (first_stage..).find(|&s| uses(s)).unwrap() - first_stage;
            let waits = passes[first.unwrap()].dependencies.iter().any(|d| {
                (d.from, d.to) == (None, Some(subpass)) && d.before.contains(&host)
            });
            let of_place = |t: &&Transition| passes[first.unwrap()].attachments[t.attachment].attachment == attachment;
            let enter = passes[first.unwrap()].enter.iter().find(of_place);
            let waits = waits || enter.is_some_and(|t| t.before.contains(&host));
            prop_assert!(waits, "attachment {attachment}");
        }
    }

    #[test]
    fn attachments_of_a_rendering_have_one_state(frame in frames(false), mut options in options()) {
        options.strategy = super::Strategy::LocalRead;
        let places = derive::place(&frame, &options);
        let pass = &derive::passes(&frame, &places, &options, options.strategy)[0];
        prop_assert!(pass.dependencies.iter().all(|d| d.from.is_some() && d.to.is_some() && d.by_region));
        prop_assert_eq!(pass.enter.len(), pass.attachments.len());
        for (index, attachment) in pass.attachments.iter().enumerate() {
            let enter = &pass.enter[index];
            prop_assert_eq!((enter.attachment, enter.from), (index, attachment.initial));
            prop_assert!(!enter.before.is_empty() && !enter.after.is_empty());
            for s in &pass.subpasses {
                let of = |list: &[usize], states: &[State]| {
                    list.iter().zip(states).filter(|(i, _)| **i == index).all(|(_, state)| *state == enter.to)
                };
                prop_assert!(of(&s.colors, &s.color_states) && of(&s.inputs, &s.input_states));
                prop_assert!(s.depth != Some(index) || s.depth_state == Some(enter.to));
                prop_assert!(s.inputs.iter().all(|&i| pass.enter[i].to == State::LocalRead));
            }
            let leaves = pass.leave.iter().find(|t| t.attachment == index);
            prop_assert_eq!(leaves.is_some(), attachment.store == Store::Store);
            prop_assert_eq!(leaves.map_or(enter.to, |t| t.to), attachment.last);
        }
    }

    #[test]
    fn recycling_saves_attachments_and_never_adds_traffic(frame in frames(false), options in options()) {
        let count = |recycle| {
            let options = Options { recycle, ..options.clone() };
            let places = derive::place(&frame, &options);
            let passes = derive::passes(&frame, &places, &options, options.strategy);
            let moved = passes.iter().flat_map(|p| &p.attachments);
            let moved = moved.filter(|a| a.load == Load::Load).count()
                + passes.iter().flat_map(|p| &p.attachments).filter(|a| a.store == Store::Store).count();
            (places.len(), moved)
        };
        let [(with, moved_with), (without, moved_without)] = [count(true), count(false)];
        prop_assert!(with <= without);
        prop_assert_eq!(without, frame.resources.len());
        prop_assert_eq!(moved_with, moved_without);
    }

    #[test]
    fn one_pass_touches_memory_only_for_what_is_kept(frame in frames(false), mut options in options()) {
        options.strategy = super::Strategy::Subpasses;
        let places = derive::place(&frame, &options);
        let passes = derive::passes(&frame, &places, &options, options.strategy);
        prop_assert_eq!(passes.len(), 1);
        let kept = frame.resources.iter().filter(|r| r.kept).count();
        prop_assert!(passes[0].attachments.iter().all(|a| a.load != Load::Load));
        prop_assert_eq!(passes[0].attachments.iter().filter(|a| a.store == Store::Store).count(), kept);
        for (index, attachment) in derive::attachments(&frame, &places, &passes, &options).iter().enumerate() {
            let stored = passes[0].attachments.iter().any(|a| a.attachment == index && a.store == Store::Store);
            prop_assert_eq!(attachment.transient, !stored);
        }
    }
}
