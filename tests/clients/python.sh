#!/usr/bin/env bash
# Generates a Python client from the document that a running server serves, and runs a whole job through it.
#
#   tests/clients/python.sh BINARY
set -uo pipefail
binary=$(realpath "${1:?usage: tests/clients/python.sh BINARY}")
cd "$(dirname "$0")/../.." || exit 1
. tests/clients/server.sh

python_tool openapi-python-client openapi-python-client==0.29.1 || exit 1
tool=target/tools/openapi-python-client
start_server "$binary" || exit 1

# Everything that the generator cannot read is a failure, not a remark.
client=$PWD/target/clients/python
rm -rf "$client" && mkdir -p "$(dirname "$client")"
PATH="$PWD/$tool/bin:$PATH" "$tool/bin/openapi-python-client" generate --url "$base/openapi.json" --output-path "$client" \
    --meta none --fail-on-warning >"$work/generated" 2>&1 || { cat "$work/generated"; exit 1; }

"$binary" sample torus --triangles 3000 -o "$work/Ring é.obj" || exit 1
PYTHONPATH=$(dirname "$client") "$tool/bin/python" tests/clients/job.py "$base" "$work/Ring é.obj" || exit 1
