//! The OpenAPI document: what the handlers say of their successes, and from the table of problems what is refused.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use utoipa::ToSchema;
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::{ContentBuilder, OpenApi as Document, Ref, RefOr, Response, ResponseBuilder};

use crate::service::http::routes::routes;
use crate::service::wire::{ProblemBody, ProblemKind};

use ProblemKind::{
    AssetInUse, BodyTooLarge, ForeignHost, ForeignOrigin, FormatNotOffered, IdempotencyConflict, Internal,
    InvalidRequest, InvalidSpec, JobFailed, MeshTooLarge, NoArtefact, NotFound, NotReady, QueueFull,
    RangeNotSatisfiable, RequestTimeout, ShuttingDown, StorageUnavailable, UnknownFormat, UnreadableMesh,
    UnsupportedExtension,
};

/// What may be wrong with an upload.
const UPLOAD: &[ProblemKind] =
    &[InvalidRequest, RequestTimeout, BodyTooLarge, MeshTooLarge, UnknownFormat, UnreadableMesh, UnsupportedExtension];
/// What may be wrong with a request for a file of a job.
const FILE: &[ProblemKind] = &[NotFound, NotReady, JobFailed];

/// What each operation refuses for reasons of its own.
const REFUSALS: &[(&str, &[&[ProblemKind]])] = &[
    ("submit_job", &[UPLOAD, &[NotFound, InvalidSpec, IdempotencyConflict, QueueFull]]),
    ("list_jobs", &[&[InvalidRequest]]),
    ("cancel_jobs", &[&[InvalidRequest]]),
    ("delete_jobs", &[&[InvalidRequest]]),
    ("get_job", &[&[NotFound]]),
    ("delete_job", &[&[NotFound]]),
    ("cancel_job", &[&[NotFound]]),
    ("job_events", &[&[NotFound]]),
    ("job_spec", &[&[NotFound]]),
    ("quad_mesh", &[FILE, &[InvalidRequest, FormatNotOffered, RangeNotSatisfiable]]),
    ("parameterisation", &[FILE, &[NoArtefact, InvalidRequest, FormatNotOffered, RangeNotSatisfiable]]),
    ("report", &[FILE, &[RangeNotSatisfiable]]),
    ("preview", &[FILE, &[InvalidRequest, RangeNotSatisfiable]]),
    ("archive", &[FILE]),
    ("upload_asset", &[UPLOAD]),
    ("get_asset", &[&[NotFound]]),
    ("delete_asset", &[&[NotFound, AssetInUse]]),
    ("list_methods", &[]),
    ("healthz", &[]),
    ("readyz", &[&[ShuttingDown, StorageUnavailable]]),
    ("metrics", &[&[StorageUnavailable]]),
];

/// The document as pretty JSON with a final newline, made once.
pub(super) fn document() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| whole().to_pretty_json().map(|json| json + "\n").unwrap_or_default())
}

fn whole() -> Document {
    let (_, mut document) = routes().split_for_parts();
    for (path, item) in &mut document.paths.paths {
        let stored = path.starts_with("/v1/jobs") || path.starts_with("/v1/assets");
        for (changes, operation) in operations(item) {
            let own = REFUSALS.iter().find(|(id, _)| operation.operation_id.as_deref() == Some(id));
            let mut kinds: Vec<ProblemKind> = own.map(|(_, kinds)| kinds.concat()).unwrap_or_default();
            kinds.extend(changes.then_some(ForeignOrigin));
            kinds.extend(stored.then_some(StorageUnavailable));
            kinds.extend([ForeignHost, Internal]);
            operation.responses.responses.extend(refusals(&kinds));
        }
    }
    document
}

/// The operations of a path that there are, and whether they change something.
fn operations(item: &mut PathItem) -> impl Iterator<Item = (bool, &mut Operation)> {
    let all = [(false, &mut item.get), (true, &mut item.post), (true, &mut item.delete)];
    all.into_iter().filter_map(|(changes, operation)| Some((changes, operation.as_mut()?)))
}

/// One response per status, which names the problems that have it.
fn refusals(kinds: &[ProblemKind]) -> impl Iterator<Item = (String, RefOr<Response>)> + use<> {
    let mut by_status = BTreeMap::<u16, Vec<String>>::new();
    for kind in kinds {
        by_status.entry(kind.status()).or_default().push(format!("`{}`: {}.", kind.slug(), kind.title()));
    }
    by_status.into_iter().map(|(status, told)| {
        let body = ContentBuilder::new().schema(Some(Ref::from_schema_name(ProblemBody::name()))).build();
        let response = ResponseBuilder::new().description(told.join(" ")).content("application/problem+json", body);
        (status.to_string(), response.build().into())
    })
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn json() -> Value {
        serde_json::from_str(document()).unwrap()
    }

    fn visit<'v>(value: &'v Value, see: &mut dyn FnMut(&'v serde_json::Map<String, Value>)) {
        match value {
            Value::Object(members) => {
                see(members);
                members.values().for_each(|member| visit(member, see));
            }
            Value::Array(items) => items.iter().for_each(|item| visit(item, see)),
            _ => {}
        }
    }

    #[test]
    fn the_checked_in_document_is_the_one_of_the_handlers() {
        let checked_in = include_str!("../../../api/openapi.json");
        assert!(checked_in == document(), "run: quadrille openapi > api/openapi.json");
    }

    #[test]
    fn every_reference_leads_to_something() {
        let document = json();
        let mut seen = 0;
        visit(&document, &mut |members| {
            if let Some(target) = members.get("$ref").and_then(Value::as_str) {
                assert!(document.pointer(target.trim_start_matches('#')).is_some(), "{target}");
                seen += 1;
            }
        });
        assert!(seen > 50);
    }

    #[test]
    fn every_operation_says_what_it_refuses() {
        let mut document = whole();
        let mut ids = Vec::new();
        for item in document.paths.paths.values_mut() {
            for (_, operation) in operations(item) {
                ids.push(operation.operation_id.clone().unwrap());
            }
        }
        ids.sort_unstable();
        let mut told: Vec<_> = REFUSALS.iter().map(|(id, _)| (*id).to_owned()).collect();
        told.sort_unstable();
        assert_eq!(ids, told);
    }

    #[test]
    fn every_time_id_and_file_has_its_format() {
        let document = json();
        let mut formats = Vec::new();
        visit(&document, &mut |members| {
            for (name, member) in members {
                let wanted = match &**name {
                    "created_at" | "started_at" | "finished_at" | "expires_at" => "date-time",
                    "id" | "asset" if member["type"] == "string" => "uuid",
                    "model/obj" | "model/gltf-binary" | "application/ply" | "image/png" => "binary",
                    _ => continue,
                };
                let schema = member.get("schema").unwrap_or(member);
                assert_eq!(schema["format"], wanted, "{name}: {member}");
                formats.push(wanted);
            }
        });
        formats.sort_unstable();
        formats.dedup();
        assert_eq!(formats, ["binary", "date-time", "uuid"]);
    }
}
