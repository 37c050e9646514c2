//! What a run has to say about its result besides the result: one table of codes, numbers and words, from which the
//! report, the job object, the lines of the command line and the OpenAPI document follow.
//!
//! Nothing in the engine decides by warnings: they are made where something is known and are only read outside.

use std::fmt::{Display, Formatter};

use glam::DVec3;

/// At most this many places are told per warning (contract: report).
const MAX_PLACES: usize = 20;

macro_rules! warnings {
    ($($(#[doc = $doc:literal])* $kind:ident = $code:literal
        { $($number:ident: $number_type:ty),* } [ $($text:ident),* ], $message:literal;)*) => {
        /// The kinds of warnings. Codes are stable; a kind has numbers, and texts that say a cause or a name.
        #[derive(Clone, Debug, PartialEq)]
        pub enum WarningKind { $(
            $(#[doc = $doc])*
            $kind {
                $(#[doc = "A number of the message."] $number: $number_type,)*
                $(#[doc = "A text of the message."] $text: String,)*
            },
        )* }

        impl WarningKind {
            /// All codes with what they mean, in the order of the table.
            pub const CODES: &'static [(&'static str, &'static str)] = &[$(($code, concat!($($doc),*)),)*];

            /// The stable code.
            pub fn code(&self) -> &'static str {
                match self { $(Self::$kind { .. } => $code,)* }
            }

            /// The numbers by name, in the order of the table.
            pub fn numbers(&self) -> Vec<(&'static str, f64)> {
                match self { $(Self::$kind { $($number,)* .. } => vec![$((stringify!($number), *$number as f64)),*],)* }
            }
        }

        impl Display for WarningKind {
            fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
                match self { $(Self::$kind { $($number,)* $($text,)* } => write!(f, $message),)* }
            }
        }
    };
}

warnings! { // code { numbers } [ texts ], message
    /// The number of quads misses the one asked for by more than 5 % (10 % below 500).
    CountMissed = "count-missed" { quads: usize, wanted: u64 } [],
        "{quads} quads instead of the {wanted} asked for";
    /// Edges above the feature angle are no chains of quad edges: noise, or detail below the size of the quads.
    FeaturesDropped = "features-dropped" { dropped: usize, detected: usize } [],
        "{dropped} of {detected} sharp edges are not kept: noise, or detail below the size of the quads; \
         more quads or explicit features.edges keep them";
    /// Quads are smaller than asked for where larger ones cannot show the detail: around some places, or all of a component.
    DensityFloor = "density-floor" { around: usize, quads: usize, wanted: usize } [],
        "detail is below the size asked for: quads are smaller around {around} places, {quads} instead of {wanted} in all";
    /// A component has quads from a level above L0, because no map of it passed the certificate.
    Fallback = "fallback" { level: u8 } [],
        "no map gave certified quads; these come from fallback level L{level}";
    /// An attempt at a component failed and another one was made.
    AttemptFailed = "attempt-failed" {} [attempt, cause],
        "{attempt}: {cause}";
    /// The method that made the quads does not follow the strokes or the field that were given.
    GuidanceIgnored = "guidance-ignored" {} [],
        "the method that made these quads follows no strokes, or no given field: see its list of what it cannot do";
    /// Branch points stay as the field has them: the working mesh is too large for their search.
    OptimiseLeftOut = "optimise-left-out" { triangles: usize } [],
        "branch points were not optimised: the working mesh has {triangles} triangles";
    /// A boundary that was to be left free is followed.
    BoundaryFollowed = "boundary-followed" {} [cause],
        "the boundary is followed, it could not be left free: {cause}";
    /// Symmetry was asked for and given up.
    SymmetryDropped = "symmetry-dropped" {} [cause],
        "symmetry was given up: {cause}";
    /// The two sides of a model differ; one of them is mirrored.
    SymmetryDeviation = "symmetry-deviation" { percent: f64 } [axis],
        "symmetry/{axis}: the side of larger {axis} is mirrored; the other one differs from that by up to {percent:.2} % \
         of the diagonal";
    /// No symmetry was asked for, and the model nearly has one.
    SymmetryOffered = "symmetry-offered" { percent: f64, normal_x: f64, normal_y: f64, normal_z: f64, offset: f64 } [],
        "the model is its own mirror image within {percent:.2} % of its diagonal at the plane with the normal \
         ({normal_x:.4}, {normal_y:.4}, {normal_z:.4}), {offset:.4} from the origin; symmetry: auto makes the quads so";
    /// Symmetry was to be found, and the model has none.
    NoSymmetry = "no-symmetry" { percent: f64 } [],
        "the model is nowhere its own mirror image within {percent:.0} % of its diagonal";
    /// A stroke is far from the surface and has no effect.
    StrokeOffSurface = "stroke-off-surface" { stroke: usize } [],
        "strokes/{stroke}: no part of the surface is near this stroke";
    /// Vertex colours were to scale the density, and the input has none.
    NoVertexColours = "no-vertex-colours" {} [],
        "density_from_vertex_colour: the input has no vertex colours";
    /// Quads and surface are further apart than two quad edges.
    Far = "far" { edges: f64, distance: f64 } [],
        "the quads and the surface are up to {edges:.1} quad edges apart ({distance:.4} of the diagonal)";
    /// Quads pass through each other where the input does not: its sheets lie closer together than the quads are large.
    SheetsIntersect = "sheets-intersect" { pairs: usize } [],
        "{pairs} pairs of quads pass through each other where the input does not: its sheets lie closer together than the \
         quads are large; more quads keep them apart";
    /// The deadline passed, and the best certified result so far is delivered.
    Deadline = "deadline" {} [effect],
        "the deadline passed: {effect}";
    /// Something that the input carries is not on the quads.
    AttributesLost = "attributes-lost" {} [what],
        "{what}";
    /// An error of ours was contained; it cost the component an attempt. Please report it.
    InternalError = "internal-error" {} [attempt],
        "{attempt}: an internal error was contained; please report it";
    /// Faces whose corners are not finite were left out.
    FacesDropped = "faces-dropped" { faces: usize } [],
        "{faces} faces with corners that are not finite were left out";
    /// Edges with more than two faces were cut apart.
    NonManifoldCut = "non-manifold-cut" { edges: usize } [],
        "{edges} edges with more than two faces were cut apart";
    /// One-sided surfaces were cut open.
    NonOrientableCut = "non-orientable-cut" { edges: usize } [],
        "one-sided surfaces were cut open along {edges} edges";
    /// Components were left out because they have no area, or are closed and have no volume.
    ComponentDropped = "component-dropped" { components: usize } [],
        "{components} components without area or volume were left out";
    /// Shells that lie upon an equal one were left out.
    DuplicateShell = "duplicate-shell" { shells: usize } [],
        "{shells} shells that lie upon an equal one were left out";
    /// The model is inside out.
    InsideOut = "inside-out" {} [],
        "the model is inside out as it was given, and so are its quads";
    /// A file in one of the formats was not made.
    FormatLeftOut = "format-left-out" {} [format, cause],
        "the {format} file does not hold these quads and is left out: {cause}";
    /// More warnings of components than are listed one by one.
    MoreWarnings = "more-warnings" { warnings: usize } [],
        "{warnings} more warnings of components";
}

/// One warning: what, of which component, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// What.
    pub kind: WarningKind,
    /// The component that it is about, in order of first faces; none if it is about the whole model.
    pub component: Option<u32>,
    /// At most 20 places in model units; empty where there are none or they are not known.
    pub places: Vec<DVec3>,
}

impl Warning {
    /// A warning about a component and about places. More than 20 places are thinned out evenly.
    pub fn new(kind: WarningKind, component: Option<u32>, places: &[DVec3]) -> Self {
        let step = places.len().div_ceil(MAX_PLACES).max(1);
        Self { kind, component, places: places.iter().copied().step_by(step).collect() }
    }
}

impl From<WarningKind> for Warning {
    fn from(kind: WarningKind) -> Self {
        Self { kind, component: None, places: Vec::new() }
    }
}

impl Display for Warning {
    /// The message, with the component before it.
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        if let Some(component) = self.component {
            write!(f, "component {component}: ")?;
        }
        write!(f, "{}", self.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_told_apart_and_stand_with_their_numbers_and_words() {
        let mut codes: Vec<&str> = WarningKind::CODES.iter().map(|(code, _)| *code).collect();
        assert!(WarningKind::CODES.iter().all(|(_, meaning)| !meaning.trim().is_empty()));
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), WarningKind::CODES.len());
        let missed = WarningKind::CountMissed { quads: 1904, wanted: 1000 };
        assert_eq!(missed.code(), "count-missed");
        assert_eq!(missed.numbers(), [("quads", 1904.0), ("wanted", 1000.0)]);
        assert_eq!(missed.to_string(), "1904 quads instead of the 1000 asked for");
    }

    #[test]
    fn many_places_are_thinned_out_evenly() {
        let places: Vec<DVec3> = (0..1000).map(|i| DVec3::X * f64::from(i)).collect();
        let warning = Warning::new(WarningKind::CountMissed { quads: 1000, wanted: 800 }, Some(2), &places);
        assert_eq!((warning.places.len(), warning.places[19]), (20, DVec3::X * 950.0));
        assert!(warning.to_string().starts_with("component 2: 1000 quads"));
    }
}
