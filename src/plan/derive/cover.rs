//! Dependencies between subpasses that others imply, or that a change of layout alone asks for.

use super::{Access, Dependencies, Frame, State, Touch};

impl Dependencies {
    /// Where one subpass waits for another for the sake of one attachment, and both use another attachment with a third subpass
    /// between them, its writes are ordered by way of the third. They are named here too, since validation layers look at each
    /// dependency by itself.
    ///
    /// Where attachments change between reading and writing more than once, or the depth that is tested is read long after it was
    /// written (`alternates`), what a subpass leaves alone is named too.
    ///
    /// Layers of 1.4 look for an attachment along each dependency, also on a subpass that comes before its first use: they find the
    /// change of layout that this use begins with, and take it for one that nothing orders. So such dependencies name the attachment.
    pub(super) fn cover(&mut self, touches: &[Touch], depth: bool, alternates: bool) {
        for (index, b) in touches.iter().enumerate().filter(|_| alternates) {
            let is_last = index + 1 == touches.len();
            for ((from, to), direct) in &mut self.0 {
                let (Some(from), Some(to)) = (*from, *to) else { continue };
                let Some(a) = touches[..index].iter().rev().find(|a| a.subpass <= from) else { continue };
                if to == b.subpass {
                    direct.before.extend(Access::of(&a.uses));
                    direct.after.extend(Access::of(&b.uses));
                    direct.after.extend(is_last.then(|| Access::store(depth)));
                }
            }
        }
        for ((from, to), direct) in &mut self.0 {
            let (Some(from), Some(to)) = (*from, *to) else { continue };
            let begins_between = (from + 1..to).contains(&touches[0].subpass);
            if let Some(b) = touches.iter().find(|b| b.subpass == to && begins_between) {
                direct.after.extend(Access::of(&b.uses));
            }
        }
        for (index, a) in touches.iter().enumerate().filter(|(_, a)| a.writes()) {
            for b in touches.iter().skip(index + 2) {
                let before = Access::of(&a.uses);
                let direct = self.0.get_mut(&(Some(a.subpass), Some(b.subpass)));
                if let Some(direct) = direct.filter(|d| !d.before.is_superset(&before)) {
                    direct.before.extend(before);
                    direct.after.extend(Access::of(&b.uses));
                }
            }
        }
    }

    /// Where reads follow each other, but in other states: the change between them is a write, and waits for those before it. Where
    /// they follow in the same state, the first begins with the change to it, for which the others wait.
    pub(super) fn rearrange(&mut self, frame: &Frame, touches: &[Touch], depth: bool) {
        let state = |touch: &Touch| State::of(&touch.uses, depth);
        let reads = touches.chunk_by(|a, b| !a.writes() && !b.writes());
        let pairs = reads
            .flat_map(|run| (1..run.len()).flat_map(move |b| run[..b].iter().map(move |a| [a, &run[b]])));
        let others = pairs.filter(|[a, b]| state(a) != state(b)).map(|pair| (pair, "in another layout"));
        let same = touches.chunk_by(|a, b| state(a) == state(b)).flat_map(|run| {
            let reads = run.iter().take_while(|touch| !touch.writes()).count();
            run[..reads].windows(2).map(|pair| ([&pair[0], &pair[1]], "in the layout that was changed to"))
        });
        for ([a, b], how) in others.chain(same) {
            let (before, after) = (Access::of(&a.uses), Access::of(&b.uses));
            let direct = self.0.get(&(Some(a.subpass), Some(b.subpass)));
            let ordered =
                direct.is_some_and(|d| d.before.is_superset(&before) && d.after.is_superset(&after));
            if !ordered {
                let why = format!("{} is read, then read {how}", frame.resources[b.resource].name);
                self.add(Some(a.subpass), Some(b.subpass), (before, after), why);
            }
        }
    }
}
