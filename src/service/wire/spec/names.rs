//! The names of the engine's choices, and of those that only requests know.

use std::collections::BTreeSet;

use crate::engine::pipeline::{
    Align, Boundary, Effort, GivenBranchPoints, NonOrientable, Optimise, Preserve, WorkingMesh,
};
use crate::service::wire::spec::choice::{Chosen, Named, choices};

choices! { Effort as "EffortName": "How much work may be spent beyond the first attempt at a component, in units that do \
                                   not depend on the machine.", later [];
    Normal = "normal": "About three times the first attempt.";
    Fast = "fast": "One attempt; what the method cannot do, sure methods do.";
    Thorough = "thorough": "About ten times the first attempt.";
}

choices! { Boundary as "BoundaryName": "What becomes of boundary loops.", later [];
    Align = "align": "The field follows them, and they become quad edges.";
    Free = "free": "The field crosses them at any angle, and a row of quads lies along each; not together with symmetry. \
                    Where a row has no room, the boundary is aligned, with a warning.";
}

choices! { Align as "AlignName": "Guidance of the cross field.", later [];
    Curvature = "curvature": "Principal curvature directions where they are stable.";
    Smooth = "smooth": "As smooth as possible.";
}

choices! { Optimise as "OptimiseName": "What is done about branch points.", later [];
    None = "none": "They stay as found.";
    Relocate = "relocate": "They move to where the field has least curl.";
    Balance = "balance": "They are also created and cancelled where that saves more than it costs in rounding.";
}

choices! { GivenBranchPoints as "FieldBranchPoints": "What becomes of the branch points of a given field.", later [];
    Keep = "keep": "They stay where the field has them, and the map follows the field exactly.";
    Optimise = "optimise": "The field is smoothed below the size of the quads and its branch points move, as `optimise` says.";
}

choices! { WorkingMesh as "WorkingMeshName": "What the parameterisation lives on.", later [];
    Auto = "auto": "A refined or remeshed copy of the input, as the density needs.";
    Input = "input": "The triangles of the input, in input order.";
}

choices! { NonOrientable as "NonOrientable": "What is done with surfaces that have only one side.", later [];
    Refuse = "refuse": "The input is refused with the reason.";
    Cut = "cut": "They are cut open along a curve.";
}

/// Kind of the resulting mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Output {
    /// Quads only.
    #[default]
    Pure,
}

choices! { Output as "OutputName": "Kind of the resulting mesh.", later ["dominant"];
    Pure = "pure": "Quads only.";
}

/// A mirror plane of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Axis {
    /// x = const.
    X,
    /// y = const.
    Y,
    /// z = const.
    Z,
}

impl Axis {
    /// The axis of a number as the engine has it, 0 to 2.
    pub fn of_index(index: usize) -> Option<Self> {
        [Axis::X, Axis::Y, Axis::Z].get(index).copied()
    }
}

choices! { Axis as "SymmetryAxis": "A mirror plane of the result, through the origin or through the middle of the model, \
                                    whichever fits the model better.", later [];
    X = "x": "x = const.";
    Y = "y": "y = const.";
    Z = "z": "z = const.";
}

impl Chosen for Axis {
    type Held = Vec<usize>;

    fn hold(chosen: BTreeSet<Self>) -> Vec<usize> {
        chosen.into_iter().map(|axis| axis as usize).collect()
    }

    fn chosen(held: &Vec<usize>) -> BTreeSet<Self> {
        held.iter().filter_map(|&index| Axis::of_index(index)).collect()
    }
}

/// An axis by name, as in a report.
pub type SymmetryAxis = Named<Axis>;

/// An attribute of the input that can be carried to the quads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Attribute {
    Materials,
    VertexColours,
    Uv,
    Skin,
}

choices! { Attribute as "AttributeName": "An attribute of the input that can be carried to the quads.", later [];
    Materials = "materials": "Material of each face.";
    VertexColours = "vertex_colours": "Colours of the vertices.";
    Uv = "uv": "Texture coordinates.";
    Skin = "skin": "Joints and weights, from glTF to GLB.";
}

impl Chosen for Attribute {
    type Held = Preserve;

    fn hold(chosen: BTreeSet<Self>) -> Preserve {
        Preserve {
            materials: chosen.contains(&Attribute::Materials),
            vertex_colours: chosen.contains(&Attribute::VertexColours),
            uv: chosen.contains(&Attribute::Uv),
            skin: chosen.contains(&Attribute::Skin),
        }
    }

    fn chosen(held: &Preserve) -> BTreeSet<Self> {
        let carried = [
            (held.materials, Attribute::Materials),
            (held.vertex_colours, Attribute::VertexColours),
            (held.uv, Attribute::Uv),
            (held.skin, Attribute::Skin),
        ];
        carried.into_iter().filter(|(is_carried, _)| *is_carried).map(|(_, attribute)| attribute).collect()
    }
}
