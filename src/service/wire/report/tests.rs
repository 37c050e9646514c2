//! The shape of the report.

use super::*;
use crate::engine::pipeline::Level;

#[test]
fn the_shape_is_the_contracts() {
    let mut input = InputReport { triangles: 12, ..InputReport::default() };
    input.repairs.add("welded", 3);
    let report = Report {
        method: "quadcover",
        certified: true,
        level: Level::L3,
        component_levels: vec![Level::L0, Level::L3],
        input,
        quads: QuadReport { valences: vec![(3, 8), (10, 1)], ..QuadReport::default() },
        map: Some(MapReport { branch_search: Some(Default::default()), ..MapReport::default() }),
        cut_by_deadline: false,
        edge_length: 0.5,
        features: FeatureReport::default(),
        symmetry: vec![MirrorPlane { normal: DVec3::Z, offset: 0.5 }],
        warnings: vec![],
    };
    let mut body = ReportBody::of(&report);
    body.set_timings(&[("read", 1.0), ("field", 2.0)], 3.5, 42);
    let json = serde_json::to_value(&body).unwrap();
    assert_eq!(json["level"], "L3");
    assert_eq!(json["input"]["repairs"]["welded"], 3);
    assert_eq!(json["symmetry"], serde_json::json!(["z"]));
    assert_eq!(json["mirror_planes"], serde_json::json!([{"normal": [0.0, 0.0, 1.0], "offset": 0.5}]));
    assert_eq!(body.findings().symmetry, report.symmetry);
    assert_eq!(json["quads"]["valences"]["10"], 1);
    assert_eq!(json["quads"]["scaled_jacobian"]["min"], 0.0);
    assert_eq!(json["timings_ms"].as_object().unwrap().keys().collect::<Vec<_>>(), ["read", "field", "total"]);
    for key in ["triangles", "flipped", "seam_residual", "singularities", "arap_mean", "branch_search"] {
        assert!(json["map"].get(key).is_some(), "{key}");
    }
    assert_eq!(serde_json::from_value::<ReportBody>(json).unwrap(), body);
}
