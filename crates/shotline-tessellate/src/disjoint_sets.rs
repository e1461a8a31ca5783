//! Sets of numbers that can be joined.

/// Sets of the numbers below a count, each of one number at first.
pub struct DisjointSets {
    /// The next member on the way to the root of the set, which is its own.
    parents: Vec<u32>,
}

impl DisjointSets {
    pub fn of(count: usize) -> DisjointSets {
        DisjointSets { parents: (0..count as u32).collect() }
    }

    /// Joins the sets of two members.
    pub fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one as u32), self.root(other as u32));
        self.parents[one.max(other) as usize] = one.min(other);
    }

    /// The number of the set of each member, in the order of their first members, and their count.
    pub fn numbered(mut self) -> (Vec<u32>, usize) {
        let members = self.parents.len() as u32;
        let mut count = 0;
        // A root is the first member of its set.
        let mut of_root = vec![0; self.parents.len()];
        let number = |member: u32| {
            let root = self.root(member);
            if root == member {
                of_root[member as usize] = count;
                count += 1;
            }
            of_root[root as usize]
        };
        let numbers = (0..members).map(number).collect();
        (numbers, count as usize)
    }

    fn root(&mut self, mut member: u32) -> u32 {
        while self.parents[member as usize] != member {
            let above = self.parents[self.parents[member as usize] as usize];
            self.parents[member as usize] = above;
            member = above;
        }
        member
    }
}
