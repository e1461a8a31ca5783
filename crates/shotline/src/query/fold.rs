//! The fold, which every query uses: it passes the boundaries of the bodies that the ray hits to the query, nearest
//! body first.

use std::ops::ControlFlow;

use super::caster::Caster;
use super::fold_query::{Fold, FoldControl, FoldQuery};
use super::stream::Stream;
use super::traversal::BodyEntry;
use super::{QueryError, Scope};
use crate::budget::StopReason;
use crate::compile::Body;
use crate::csg::{Boundary, HitKind};
use crate::ray::{Line, Ray, Span};
use crate::solid::Wanted;
use crate::trace::Act;

impl<'w> Caster<'w> {
    /// Passes every boundary in the scope to `fold`, body by body: first the hinted body, then the others from the
    /// nearest to the farthest.
    ///
    /// # Errors
    /// [`QueryError::Cancelled`] and [`QueryError::TooLong`]; then the boundaries passed so far are invalid.
    pub(super) fn fold(
        &mut self,
        ray: &Ray,
        query: &FoldQuery,
        fold: &mut Fold<'_, 'w>,
    ) -> Result<(), QueryError> {
        let _ = self.fold_bodies(ray, query, fold);
        self.outcome()
    }

    fn fold_bodies(&mut self, ray: &Ray, query: &FoldQuery, fold: &mut Fold<'_, 'w>) -> ControlFlow<()> {
        let span = query.scope.span;
        let mut limit = span.t_max();
        self.scratch.budget.begin(self.limits.steps);
        self.traversal.begin(self.world, Line::of(ray), span);
        let hinted = self.traversal.descend_along(self.world, query.hint, &mut self.scratch.counters);
        if let Some(body_entry) = &hinted {
            self.fold_body(body_entry, query, &mut limit, fold)?;
        }
        self.traversal.enter_root(self.world, &mut self.scratch);
        while let Some(body_entry) = self.traversal.next(self.world, limit, &mut self.scratch) {
            let again = hinted.is_some_and(|a| a.placed.path == body_entry.placed.path);
            if !again {
                self.fold_body(&body_entry, query, &mut limit, fold)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Passes the boundaries of one body up to the limit, which the query may lower.
    pub(super) fn fold_body(
        &mut self,
        body_entry: &BodyEntry,
        query: &FoldQuery,
        limit: &mut f64,
        fold: &mut Fold<'_, 'w>,
    ) -> ControlFlow<()> {
        let Scope { span, kinds } = query.scope;
        // Boundaries beyond the limit do not matter, but those at the limit itself do.
        let end = *limit;
        let traversal = &mut self.traversal;
        let mut emit = |mut boundary: Boundary| {
            // Turns -0.0 into 0.0, because -0.0 would sort before it.
            boundary.crossing.t += 0.0;
            match fold(traversal, body_entry, boundary) {
                FoldControl::Limit(t) => {
                    *limit = limit.min(t);
                    ControlFlow::Continue(())
                }
                FoldControl::Stop => ControlFlow::Break(()),
            }
        };
        match self.world.body(body_entry.placed.body) {
            Body::Solid(body) => {
                // If the span may begin inside the body, its first boundary may be of a kind that is not in the
                // scope.
                let within = body_entry.enter <= span.t_min();
                let mut wanted =
                    if within && !kinds.hold(HitKind::Start) { Wanted::All } else { query.wanted };
                'again: loop {
                    let line = &body_entry.line;
                    let mut stream =
                        Stream::new(body, line, span, wanted, &mut self.stream, &mut self.scratch);
                    // The span is not cut at the limit: which crossings are one event, and so the first boundary,
                    // would depend on the bodies that were visited before.
                    while let Some(boundary) = stream.next().filter(|boundary| boundary.crossing.t <= end) {
                        stream.log().add(1, Some(boundary.crossing.t), || described(&boundary));
                        if kinds.hold(boundary.kind) {
                            emit(boundary)?;
                            if query.wanted == Wanted::First {
                                break;
                            }
                        } else if wanted == Wanted::First {
                            // Only rounding can make the span begin inside a body whose box begins later. Run
                            // again for all boundaries.
                            wanted = Wanted::All;
                            continue 'again;
                        }
                    }
                    break;
                }
            }
            Body::Surface(body) => {
                self.hits.clear();
                let line = body_entry.line.in_frame(&body.local_from_body);
                let span = if end < span.t_max() {
                    Span::new(span.t_min(), end.next_up()).unwrap_or(span)
                } else {
                    span
                };
                self.scratch.log.add(1, None, || Act::Test { item: "mesh".into() });
                match query.wanted {
                    Wanted::All => body.mesh.hits(&line, span, &mut self.hits, &mut self.scratch),
                    Wanted::First => self.hits.extend(body.mesh.nearest(&line, span, &mut self.scratch)),
                }
                self.scratch.log.add(1, None, || Act::Found { crossings: self.hits.clone() });
                for &crossing in &self.hits {
                    let entering = crossing.entering;
                    let boundary = Boundary { kind: HitKind::Surface, entering, leaf: 0, crossing };
                    self.scratch.log.add(1, Some(crossing.t), || described(&boundary));
                    emit(boundary)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Returns an error if the budget of the ray has ended.
    pub(super) fn outcome(&self) -> Result<(), QueryError> {
        match self.scratch.budget.ended() {
            None => Ok(()),
            Some(StopReason::Cancelled) => Err(QueryError::Cancelled),
            Some(StopReason::Exhausted) => Err(QueryError::TooLong { most: self.limits.steps }),
        }
    }
}

fn described(boundary: &Boundary) -> Act {
    match boundary.kind {
        HitKind::Surface => Act::Boundary { entering: boundary.entering },
        HitKind::Start => Act::Start,
        HitKind::End => Act::End,
    }
}
