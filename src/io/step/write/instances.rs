//! Instances of a STEP file, numbered in the order in which they are written.

use std::fmt::Write as _;

use crate::geometry::Point;

/// The instances written so far.
#[derive(Default)]
pub struct Instances {
    text: String,
    last: u32,
}

/// An edge: its instance and those of its vertices, in its direction.
#[derive(Clone, Copy)]
pub struct Edge {
    /// Number of the `EDGE_CURVE`.
    pub id: u32,
}

/// A use of an edge by a loop: the edge, and whether in its own direction.
pub type EdgeUse = (Edge, bool);

/// Knots of a clamped B-spline: values with multiplicities.
pub struct ClampedKnots<'a> {
    /// Distinct values, increasing.
    pub values: &'a [f64],
    /// Multiplicity of the inner ones; the outer ones have degree + 1.
    pub inner: usize,
}

impl Instances {
    /// Adds an instance; returns its number.
    pub fn add(&mut self, instance: &str) -> u32 {
        self.last += 1;
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "#{}={instance};", self.last);
        self.last
    }

    /// The lines of all instances.
    pub fn text(self) -> String {
        self.text
    }

    /// A `CARTESIAN_POINT`.
    pub fn point(&mut self, p: [f64; 3]) -> u32 {
        self.add(&format!("CARTESIAN_POINT('',{})", triple(p)))
    }

    /// A `DIRECTION`.
    pub fn direction(&mut self, d: [f64; 3]) -> u32 {
        self.add(&format!("DIRECTION('',{})", triple(d)))
    }

    /// A frame with its Z along `axis`, which is along Z of the file, and its X along X.
    pub fn frame(&mut self, origin: [f64; 3], axis: [f64; 3]) -> u32 {
        let (origin, z, x) = (self.point(origin), self.direction(axis), self.direction([1.0, 0.0, 0.0]));
        self.add(&format!("AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})"))
    }

    /// A `VERTEX_POINT`.
    pub fn vertex(&mut self, p: [f64; 3]) -> u32 {
        let point = self.point(p);
        self.add(&format!("VERTEX_POINT('',#{point})"))
    }

    /// A B-spline curve.
    pub fn curve(&mut self, degree: usize, control: &[[f64; 3]], knots: &ClampedKnots<'_>) -> u32 {
        let points: Vec<u32> = control.iter().map(|p| self.point(*p)).collect();
        let (counts, values) = knots.lists(degree);
        self.add(&format!(
            "B_SPLINE_CURVE_WITH_KNOTS('',{degree},{},.UNSPECIFIED.,.F.,.F.,{counts},{values},.UNSPECIFIED.)",
            list(&points)
        ))
    }

    /// A B-spline surface; `control` are its rows by the first parameter.
    pub fn surface(
        &mut self,
        degrees: [usize; 2],
        control: &[Vec<[f64; 3]>],
        knots: [&ClampedKnots<'_>; 2],
    ) -> u32 {
        let rows: Vec<String> = control
            .iter()
            .map(|row| list(&row.iter().map(|p| self.point(*p)).collect::<Vec<u32>>()))
            .collect();
        let ([counts_u, values_u], [counts_v, values_v]) = (
            <[String; 2]>::from(knots[0].lists(degrees[0])),
            <[String; 2]>::from(knots[1].lists(degrees[1])),
        );
        self.add(&format!(
            "B_SPLINE_SURFACE_WITH_KNOTS('',{},{},({}),.UNSPECIFIED.,.F.,.F.,.F.,{counts_u},{counts_v},\
             {values_u},{values_v},.UNSPECIFIED.)",
            degrees[0],
            degrees[1],
            rows.join(",")
        ))
    }

    /// An edge on a curve between two vertices.
    pub fn edge(&mut self, from: u32, to: u32, curve: u32) -> Edge {
        Edge { id: self.add(&format!("EDGE_CURVE('',#{from},#{to},#{curve},.T.)")) }
    }

    /// A straight edge between two vertices at `a` and `b`.
    pub fn straight_edge(&mut self, (from, a): (u32, Point), (to, b): (u32, Point)) -> Edge {
        let way = b - a;
        let direction = way.try_normalize(0.0).unwrap_or_else(crate::geometry::Vector::x);
        let (start, direction) = (self.point(a.into()), self.direction(direction.into()));
        let vector = self.add(&format!("VECTOR('',#{direction},{})", real(way.norm())));
        let line = self.add(&format!("LINE('',#{start},#{vector})"));
        self.edge(from, to, line)
    }

    /// A full circle about Z from the vertex at `[radius, 0, z]`, counter-clockwise seen from +Z.
    pub fn circle(&mut self, vertex: u32, radius: f64, z: f64) -> Edge {
        let frame = self.frame([0.0, 0.0, z], [0.0, 0.0, 1.0]);
        let circle = self.add(&format!("CIRCLE('',#{frame},{})", real(radius)));
        self.edge(vertex, vertex, circle)
    }

    /// A face of a surface within loops, which run counter-clockwise about its normal; `same_sense`: that is
    /// the surface's own.
    pub fn face(&mut self, loops: &[Vec<EdgeUse>], surface: u32, same_sense: bool) -> u32 {
        let mut bounds = Vec::new();
        for (k, edges) in loops.iter().enumerate() {
            let uses: Vec<u32> = edges
                .iter()
                .map(|(edge, forward)| {
                    self.add(&format!("ORIENTED_EDGE('',*,*,#{},{})", edge.id, logical(*forward)))
                })
                .collect();
            let edges = self.add(&format!("EDGE_LOOP('',{})", list(&uses)));
            let kind = if k == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
            bounds.push(self.add(&format!("{kind}('',#{edges},.T.)")));
        }
        self.add(&format!("ADVANCED_FACE('',{},#{surface},{})", list(&bounds), logical(same_sense)))
    }

    /// A closed solid of faces.
    pub fn solid(&mut self, name: &str, faces: &[u32]) -> u32 {
        let shell = self.add(&format!("CLOSED_SHELL('',{})", list(faces)));
        self.add(&format!("MANIFOLD_SOLID_BREP({},#{shell})", quoted(name)))
    }
}

impl ClampedKnots<'_> {
    fn lists(&self, degree: usize) -> (String, String) {
        let last = self.values.len().saturating_sub(1);
        let count = |k: usize| if k == 0 || k == last { degree + 1 } else { self.inner };
        let counts: Vec<String> = (0..self.values.len()).map(|k| count(k).to_string()).collect();
        let values: Vec<String> = self.values.iter().map(|v| real(*v)).collect();
        (format!("({})", counts.join(",")), format!("({})", values.join(",")))
    }
}

/// References in brackets.
pub fn list(ids: &[u32]) -> String {
    let ids: Vec<String> = ids.iter().map(|id| format!("#{id}")).collect();
    format!("({})", ids.join(","))
}

/// A number, always with a point.
pub fn real(x: f64) -> String {
    let text = format!("{x:.12}");
    match text.trim_end_matches('0') {
        "-0." => "0.".to_owned(),
        short => short.to_owned(),
    }
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("({},{},{})", real(x), real(y), real(z))
}

fn logical(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}

/// A string: quotes doubled, what is not printable ASCII by its code.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("'");
    for c in text.chars() {
        match c {
            '\'' => out += "''",
            '\\' => out += "\\\\",
            ' '..='~' => out.push(c),
            // Writing to a string does not fail.
            _ => drop(write!(out, "\\X4\\{:08X}\\X0\\", c as u32)),
        }
    }
    out + "'"
}
