//! Bodies of a file with their placements, from the tree of representations.
//!
//! A representation holds bodies, and others of it: by mapped items, or by relationships with a
//! transformation (one for each occurrence of a component in an assembly).

use std::collections::{BTreeMap, BTreeSet};

use super::exchange::Value;
use super::model::{EntityArguments, EntityFault, EntityResult, Frame, Model, Units};
use crate::geometry::Point;

/// Deepest nesting of assemblies.
const MAX_LEVELS: usize = 64;
/// Largest number of visits to representations; a file of a few lines could ask for any number of them.
const MAX_VISITS: usize = 200_000;
/// Largest number of placed bodies.
const MAX_BODIES: usize = 20_000;
/// Kinds of items that are bodies.
const BODIES: [&str; 6] = [
    "MANIFOLD_SOLID_BREP",
    "BREP_WITH_VOIDS",
    "FACETED_BREP",
    "FACETED_BREP_AND_BREP_WITH_VOIDS",
    "SHELL_BASED_SURFACE_MODEL",
    "FACE_BASED_SURFACE_MODEL",
];

/// One body at its place.
#[derive(Clone, Debug)]
pub struct PlacedBody {
    /// Its instance.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// Names of the components it is in, the innermost first.
    pub parents: Vec<String>,
    /// Units of its representation.
    pub units: Units,
    /// From its representation to the file's frame.
    pub placement: Placement,
}

impl PlacedBody {
    /// Whether another one is in the same units and moved alike.
    pub fn is_beside(&self, other: &Self) -> bool {
        self.units == other.units && self.placement == other.placement
    }
}

/// A rigid motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    frame: Frame,
}

impl Placement {
    /// The motion that takes the frame `from` to `to`.
    fn between(from: &Frame, to: &Frame) -> Self {
        let origin = Frame { origin: Point::origin(), axes: to.axes };
        let turned = |axis: usize| {
            let mut unit = crate::geometry::Vector::zeros();
            unit[axis] = 1.0;
            let rotated = Frame { origin: Point::origin(), axes: from.axes };
            origin.direction(rotated.local(&Point::from(unit)))
        };
        let axes = [turned(0), turned(1), turned(2)];
        let moved = Frame { origin: Point::origin(), axes }.world(from.origin.coords);
        Self { frame: Frame { origin: Point::from(to.origin - moved), axes } }
    }

    /// This motion, then `outer`.
    fn then(&self, outer: &Self) -> Self {
        Self {
            frame: Frame {
                origin: outer.apply(&self.frame.origin),
                axes: self.frame.axes.map(|axis| outer.frame.direction(axis)),
            },
        }
    }

    /// The point after the motion.
    pub fn apply(&self, p: &Point) -> Point {
        self.frame.world(p.coords)
    }
}

/// A representation within another.
struct Occurrence {
    child: u32,
    placement: Placement,
    name: String,
}

/// The tree of representations.
struct Tree<'m, 'a> {
    model: &'m Model<'a>,
    /// Others in the same frame, both ways.
    same: BTreeMap<u32, Vec<u32>>,
    parts: BTreeMap<u32, Vec<Occurrence>>,
    /// Representations that are within another.
    children: BTreeSet<u32>,
    found: Vec<PlacedBody>,
    visits: usize,
}

/// All bodies of a file at their places, in the order of the tree.
///
/// # Errors
/// When a placement or unit is not understood, or the tree contains itself.
pub fn placed_bodies(model: &Model<'_>) -> EntityResult<Vec<PlacedBody>> {
    let mut tree = Tree {
        model,
        same: BTreeMap::new(),
        parts: BTreeMap::new(),
        children: BTreeSet::new(),
        found: Vec::new(),
        visits: 0,
    };
    tree.read_relationships()?;
    let representations: Vec<u32> =
        model.exchange.iter().filter(|i| is_representation(i.keyword())).map(|i| i.id).collect();
    let mut seen = BTreeSet::new();
    for id in &representations {
        let group = tree.group(*id);
        if group.iter().any(|id| tree.children.contains(id)) || seen.contains(id) {
            continue;
        }
        seen.extend(group);
        tree.walk(*id, &Placement::default(), &mut Vec::new(), &mut Vec::new())?;
    }
    // Bodies in no representation, or in a circle of them: as they are.
    let placed: BTreeSet<u32> = tree.found.iter().map(|b| b.id).collect();
    for instance in model.exchange.iter().filter(|i| BODIES.iter().any(|b| i.record(b).is_some())) {
        let id = instance.id;
        // The parts of a combined body are not bodies of their own.
        if !placed.contains(&id) && !instance.records.is_empty() {
            tree.push(id, &Placement::default(), model.units(None)?, &[])?;
        }
    }
    Ok(tree.found)
}

fn is_representation(keyword: &str) -> bool {
    // Despite its name it relates two representations and is not one itself.
    keyword != "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"
        && (keyword.ends_with("_SHAPE_REPRESENTATION")
            || ["SHAPE_REPRESENTATION", "REPRESENTATION"].contains(&keyword))
}

impl Tree<'_, '_> {
    fn read_relationships(&mut self) -> EntityResult<()> {
        let model = self.model;
        // By relationship: the representations of the component of an occurrence, and the occurrence's name.
        let mut of_component: BTreeMap<u32, (BTreeSet<u32>, String)> = BTreeMap::new();
        let mut of_product: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        let definition = |from: u32, shape: u32| -> Option<u32> {
            model.expect(from, shape, &["PRODUCT_DEFINITION_SHAPE"]).ok()?.reference(2).ok()
        };
        for a in model.all("SHAPE_DEFINITION_REPRESENTATION") {
            if let (Some(product), Some(shape)) =
                (a.optional(0).and_then(|s| definition(a.id, s)), a.optional(1))
            {
                of_product.entry(product).or_default().insert(shape);
            }
        }
        for a in model.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION") {
            let usage = a.optional(1).and_then(|s| definition(a.id, s));
            let usage = usage.and_then(|u| model.expect(a.id, u, &["NEXT_ASSEMBLY_USAGE_OCCURRENCE"]).ok());
            if let (Some(relationship), Some(usage)) = (a.optional(0), usage) {
                let component =
                    usage.optional(4).and_then(|c| of_product.get(&c)).cloned().unwrap_or_default();
                of_component.insert(relationship, (component, usage.text(1)));
            }
        }
        for instance in model.exchange.iter() {
            let record = |name: &str| instance.record(name).map(|v| EntityArguments::new(instance.id, v));
            let Some(pair) = record("REPRESENTATION_RELATIONSHIP").or_else(|| {
                record("SHAPE_REPRESENTATION_RELATIONSHIP").filter(|_| instance.records.len() == 1)
            }) else {
                continue;
            };
            let (first, second) = (pair.reference(2)?, pair.reference(3)?);
            let Some(moved) = record("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION") else {
                self.same.entry(first).or_default().push(second);
                self.same.entry(second).or_default().push(first);
                continue;
            };
            let empty = (BTreeSet::new(), String::new());
            let (component, name) = of_component.get(&instance.id).unwrap_or(&empty);
            // Exporters disagree on the order: the component is the child.
            let within = |id: u32| self.group(id).iter().any(|id| component.contains(id));
            let (child, parent) =
                if !within(first) && within(second) { (second, first) } else { (first, second) };
            let items = model.expect(moved.id, moved.reference(0)?, &["ITEM_DEFINED_TRANSFORMATION"])?;
            let (mut from, mut to) = (items.reference(2)?, items.reference(3)?);
            if child == second {
                std::mem::swap(&mut from, &mut to);
            }
            // … and on the order of the placements: each is an item of its representation.
            if !self.has_item(child, from) && !self.has_item(parent, to)
                || self.has_item(parent, from) && !self.has_item(parent, to)
            {
                std::mem::swap(&mut from, &mut to);
            }
            let frame = |placement: u32, of: u32| -> EntityResult<Frame> {
                model.frame(items.id, placement, self.units(of)?.mm)
            };
            let placement = Placement::between(&frame(from, child)?, &frame(to, parent)?);
            self.children.extend(self.group(child));
            let name = name.clone();
            self.parts.entry(parent).or_default().push(Occurrence { child, placement, name });
        }
        for instance in model.exchange.iter().filter(|i| is_representation(i.keyword())) {
            let a =
                EntityArguments::new(instance.id, instance.record(instance.keyword()).unwrap_or_default());
            for item in a.list(1).unwrap_or_default().iter().filter_map(Value::reference) {
                let Some(mapped) = model.exchange.get(item).and_then(|i| i.record("MAPPED_ITEM")) else {
                    continue;
                };
                let mapped = EntityArguments::new(item, mapped);
                let map = model.expect(item, mapped.reference(1)?, &["REPRESENTATION_MAP"])?;
                let child = map.reference(1)?;
                let from = model.frame(map.id, map.reference(0)?, self.units(child)?.mm)?;
                let to = model.frame(item, mapped.reference(2)?, self.units(instance.id)?.mm)?;
                let placement = Placement::between(&from, &to);
                self.children.extend(self.group(child));
                let occurrence = Occurrence { child, placement, name: mapped.text(0) };
                self.parts.entry(instance.id).or_default().push(occurrence);
            }
        }
        Ok(())
    }

    fn arguments(&self, representation: u32) -> Option<EntityArguments<'_, '_>> {
        let instance = self.model.exchange.get(representation)?;
        Some(EntityArguments::new(representation, instance.record(instance.keyword())?))
    }

    fn has_item(&self, representation: u32, item: u32) -> bool {
        let holds = |id: &u32| {
            self.arguments(*id)
                .and_then(|a| a.list(1).ok())
                .is_some_and(|items| items.iter().any(|v| v.reference() == Some(item)))
        };
        self.group(representation).iter().any(holds)
    }

    fn units(&self, representation: u32) -> EntityResult<Units> {
        self.model.units(self.arguments(representation).and_then(|a| a.optional(2)))
    }

    /// A representation and those in the same frame.
    fn group(&self, id: u32) -> Vec<u32> {
        let mut group = vec![id];
        let mut at = 0;
        while let Some(own) = group.get(at).copied() {
            at += 1;
            for other in self.same.get(&own).into_iter().flatten() {
                if !group.contains(other) {
                    group.push(*other);
                }
            }
        }
        group.sort_unstable();
        group
    }

    fn walk(
        &mut self,
        id: u32,
        placement: &Placement,
        above: &mut Vec<u32>,
        names: &mut Vec<String>,
    ) -> EntityResult<()> {
        if above.contains(&id) {
            return Err(EntityFault::new(id, "is an assembly that contains itself"));
        }
        self.visits += 1;
        if self.visits > MAX_VISITS {
            return Err(EntityFault::new(id, format!("is one of more than {MAX_VISITS} components")));
        }
        if above.len() >= MAX_LEVELS {
            return Err(EntityFault::new(id, format!("is nested more than {MAX_LEVELS} assemblies deep")));
        }
        let group = self.group(id);
        let depth = above.len();
        above.extend(&group);
        for own in &group {
            let Some(a) = self.arguments(*own) else { continue };
            names.push(a.text(0));
            let items: Vec<u32> = a.list(1)?.iter().filter_map(Value::reference).collect();
            let is_body = |id: &u32| {
                self.model.exchange.get(*id).is_some_and(|i| BODIES.iter().any(|b| i.record(b).is_some()))
            };
            let bodies: Vec<u32> = items.into_iter().filter(is_body).collect();
            let units = self.units(*own)?;
            for body in bodies {
                self.push(body, placement, units, names)?;
            }
            let parts: Vec<(u32, Placement, String)> = self
                .parts
                .get(own)
                .into_iter()
                .flatten()
                .map(|o| (o.child, o.placement.then(placement), o.name.clone()))
                .collect();
            for (child, placement, name) in parts {
                names.push(name);
                // Levels are counted, not the representations of a level.
                let mut path = above.clone();
                self.walk(child, &placement, &mut path, names)?;
                names.pop();
            }
            names.pop();
        }
        above.truncate(depth);
        Ok(())
    }

    fn push(&mut self, id: u32, placement: &Placement, units: Units, names: &[String]) -> EntityResult<()> {
        if self.found.len() >= MAX_BODIES {
            return Err(EntityFault::new(id, format!("is one of more than {MAX_BODIES} bodies")));
        }
        let instance = self.model.instance(id, id)?;
        let record = instance.record("REPRESENTATION_ITEM").or_else(|| instance.record(instance.keyword()));
        let name = EntityArguments::new(id, record.unwrap_or_default()).text(0);
        let mut parents: Vec<String> = names.iter().rev().filter(|n| !n.is_empty()).cloned().collect();
        parents.dedup();
        self.found.push(PlacedBody { id, name, parents, units, placement: *placement });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    #[test]
    fn a_placement_takes_one_frame_to_the_other() {
        let from = Frame::new(Point::new(1.0, 2.0, 3.0), Vector::z(), Vector::new(1.0, 1.0, 0.0));
        let to = Frame::new(Point::new(-4.0, 0.0, 5.0), Vector::x(), Vector::y());
        let placement = Placement::between(&from, &to);
        for q in [Vector::zeros(), Vector::x(), Vector::new(0.3, -2.0, 7.0)] {
            assert!((placement.apply(&from.world(q)) - to.world(q)).norm() < 1e-12);
        }
        let back = placement.then(&Placement::between(&to, &from));
        let p = Point::new(9.0, -1.0, 0.5);
        assert!((back.apply(&p) - p).norm() < 1e-12);
    }
}
