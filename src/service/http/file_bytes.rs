//! Files in the OpenAPI document.

use utoipa::ToSchema;

/// The bytes of a file. Generators of clients know them by the format; their length says nothing.
#[derive(Debug, ToSchema)]
#[schema(value_type = String, format = Binary)]
#[expect(dead_code, reason = "only its schema is used; files are streams")]
pub(super) struct FileBytes(Vec<u8>);
