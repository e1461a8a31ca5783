//! The instances of objects that some paths run through. An instance is one placement of an object; nothing is stored for
//! it in the world.

use crate::compile::{Level, Target, World};

/// No instance.
pub(super) const NONE: u32 = u32::MAX;

/// One placement of an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instance {
    pub object: u32,
    /// The innermost instance that it is in, and the innermost of those whose contents count only inside them; or [`NONE`].
    pub parent: u32,
    pub clip: u32,
    /// The instances in it are those from the next one to this one.
    pub end: u32,
}

/// A scope or a level on the way to a path.
#[derive(Clone, Copy, Debug)]
struct Open<'w> {
    instance: u32,
    level: &'w Level,
    scope: Option<u32>,
    /// The first path of the level, and the path after the last one of the scope or level.
    first_path: u64,
    end: u64,
}

/// The instances on the way to some paths, in the order of the paths. Each comes after those that it is in.
#[derive(Debug, Default)]
pub(super) struct Instances<'w> {
    all: Vec<Instance>,
    open: Vec<Open<'w>>,
    /// The last path, and its innermost instance.
    last: Option<(u64, u32)>,
}

impl<'w> Instances<'w> {
    /// Begins without paths.
    pub fn begin(&mut self, world: &'w World) {
        self.all.clear();
        self.open.clear();
        self.last = None;
        let level = world.root();
        self.open.push(Open { instance: NONE, level, scope: None, first_path: 0, end: level.path_count });
    }

    /// The innermost instance on the way to a path. Paths have to ascend.
    pub fn of_path(&mut self, world: &'w World, path: u64) -> u32 {
        if let Some((last, instance)) = self.last
            && last == path
        {
            return instance;
        }
        while self.open.len() > 1 && self.open.last().is_some_and(|open| open.end <= path) {
            self.open.pop();
        }
        let instance = loop {
            if let Some(instance) = self.descend(world, path) {
                break instance;
            }
        };
        self.last = Some((path, instance));
        instance
    }

    /// Goes on by one placement. Returns the instance of a body.
    fn descend(&mut self, world: &'w World, path: u64) -> Option<u32> {
        let Open { level, first_path, .. } = self.open[self.open.len() - 1];
        let placed = level.placement(level.placement_of_path(path - first_path));
        self.open_scopes(world, placed.scope);
        let around = self.open[self.open.len() - 1];
        let begins =
            |object: &u32| around.scope.is_none_or(|scope| level.scopes[scope as usize].object != *object);
        let instance = match placed.object.filter(begins) {
            Some(object) => self.add(world, object, around.instance),
            None => around.instance,
        };
        match placed.target {
            Target::Body(_) => Some(instance),
            Target::Level(below) => {
                let (level, first_path) = (world.level(below), first_path + placed.first_path);
                let end = first_path + level.path_count;
                self.open.push(Open { instance, level, scope: None, first_path, end });
                None
            }
        }
    }

    /// Opens the scopes around a placement that are not open yet, outermost first.
    fn open_scopes(&mut self, world: &World, innermost: Option<u32>) {
        let Open { level, first_path, scope: opened, .. } = self.open[self.open.len() - 1];
        let first = self.open.len();
        let mut next = innermost;
        while let Some(number) = next.filter(|_| next != opened) {
            let scope = &level.scopes[number as usize];
            let end = first_path + scope.paths.end;
            self.open.push(Open { instance: NONE, level, scope: next, first_path, end });
            next = scope.parent;
        }
        self.open[first..].reverse();
        for place in first..self.open.len() {
            let parent = self.open[place - 1].instance;
            if let Some(scope) = self.open[place].scope {
                self.open[place].instance = self.add(world, level.scopes[scope as usize].object, parent);
            }
        }
    }

    fn add(&mut self, world: &World, object: u32, parent: u32) -> u32 {
        let number = self.all.len() as u32;
        let clip = match self.all.get(parent as usize) {
            Some(above) if world.object_clips(above.object) => parent,
            Some(above) => above.clip,
            None => NONE,
        };
        self.all.push(Instance { object, parent, clip, end: number });
        number
    }

    /// All instances, once [`Instances::finish`] has been called.
    pub fn all(&self) -> &[Instance] {
        &self.all
    }

    /// Ends the paths.
    pub fn finish(&mut self) -> &[Instance] {
        for number in (0..self.all.len()).rev() {
            let Instance { parent, end, .. } = self.all[number];
            if let Some(above) = self.all.get_mut(parent as usize) {
                above.end = above.end.max(end);
            }
        }
        &self.all
    }
}

/// Whether an instance is in another.
pub(super) fn is_in(instances: &[Instance], inner: u32, outer: u32) -> bool {
    outer < inner && inner <= instances[outer as usize].end
}
