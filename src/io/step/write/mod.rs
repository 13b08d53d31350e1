//! Writes a part as STEP (ISO 10303-21, AP214): hub body and blades as closed solids, the shroud as a sheet.
//!
//! Blade sides are the part's own surfaces, bicubic (or ruled) B-splines, without approximation. Hub and
//! shroud are surfaces of revolution of B-spline curves within 1e-7 mm (`CURVE_ERROR` of `spline.rs`); tips
//! lie on the shroud, feet on the hub.
//!
//! | file | contents |
//! |---|---|
//! | `instances` | numbered instances: points, curves, edges, faces |
//! | `spline` | control points of piecewise cubics |
//! | `turned` | hub body and shroud |
//! | `blade` | blades |

mod blade;
mod instances;
mod spline;
mod turned;

use instances::{Instances, quoted};

use super::read::ROTATION_NOTE;
use crate::part::{Blade, Impeller};

/// Distance within which edges lie on their faces, mm: trailing edges are straight between both sides.
const UNCERTAINTY: f64 = 1e-3;

/// The text of a STEP file with a part, in mm, about Z. `file` is the name in its header.
///
/// The back of the wheel is not part of a part: a plain one is written, as in glTF files.
pub fn write_part(part: &Impeller, file: &str) -> String {
    let mut out = Instances::default();
    let application = out.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
    out.add(&format!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2010,#{application})"
    ));
    let product_context = out.add(&format!("PRODUCT_CONTEXT('',#{application},'mechanical')"));
    let name = quoted(&part.name);
    let turning = quoted(&format!("{ROTATION_NOTE}{}", part.rotation().name()));
    let product = out.add(&format!("PRODUCT({name},{name},{turning},(#{product_context}))"));
    let formation = out.add(&format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
    let definition_context =
        out.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')"));
    let definition = out.add(&format!("PRODUCT_DEFINITION('design','',#{formation},#{definition_context})"));
    let shape = out.add(&format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"));
    let length = out.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    let angle = out.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let solid_angle = out.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    let uncertainty = out.add(&format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),#{length},'distance_accuracy_value','')",
        instances::real(UNCERTAINTY)
    ));
    let context = out.add(&format!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{uncertainty}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid_angle}))REPRESENTATION_CONTEXT('',''))"
    ));
    let mut items = vec![out.frame([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])];
    let all: Vec<&Blade> = std::iter::once(&part.main).chain(&part.splitters).collect();
    let hub = turned::hub_surface(&mut out, part, &all);
    let shroud = turned::shroud_surface(&mut out, part);
    items.push(turned::hub_body(&mut out, part, &hub));
    let floors = [(&part.hub, &hub, 0.0), (&part.shroud, &shroud, 1.0)]
        .map(|(path, own, v)| turned::floor_surface(&mut out, (path, own), &all, v));
    let rows = std::iter::once((&part.main, "blade".to_owned())).chain(
        part.splitters.iter().enumerate().map(|(k, splitter)| {
            let row = if part.splitters.len() > 1 { format!(".{}", k + 1) } else { String::new() };
            (splitter, format!("splitter{row}"))
        }),
    );
    for (blade, name) in rows {
        for k in 0..part.blade_count {
            let turn = part.pitch() * k as f64;
            let name = format!("{name} {}", k + 1);
            items.push(blade::blade_body(&mut out, part, &blade.rotated(turn), floors, &name));
        }
    }
    items.push(turned::shroud_sheet(&mut out, &shroud));
    let items = instances::list(&items);
    let representation = out.add(&format!("SHAPE_REPRESENTATION({name},{items},#{context})"));
    out.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})"));
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('impeller'),'2;1');\n\
         FILE_NAME({},'1970-01-01T00:00:00',(''),(''),'vanecut','vanecut','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 3 1 1 1 }}'));\nENDSEC;\nDATA;\n{}ENDSEC;\n\
         END-ISO-10303-21;\n",
        quoted(file),
        out.text()
    )
}
