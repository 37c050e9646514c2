#!/usr/bin/env bash
# Asks a running server for everything that its document allows, and for much that it does not: no answer may be a fault of
# the server, have a status, a header or a shape that the document does not tell of.
#
#   tests/clients/schemathesis.sh BINARY [CASES PER OPERATION AND PHASE]
set -uo pipefail
binary=$(realpath "${1:?usage: tests/clients/schemathesis.sh BINARY [CASES]}")
cases=${2:-15}
least=1000
cd "$(dirname "$0")/../.." || exit 1
. tests/clients/server.sh

python_tool schemathesis schemathesis==4.32.5 || exit 1
# Small limits: it is about answers, not about geometry. The queue is long, because 503 would be no fault.
start_server "$binary" QUADRILLE_LIMITS__UPLOAD_BYTES=100000 QUADRILLE_LIMITS__VERTICES=1000 \
    QUADRILLE_LIMITS__TRIANGLES=1000 QUADRILLE_LIMITS__DEADLINE_S=10 QUADRILLE_LIMITS__QUEUED_JOBS=100000 \
    QUADRILLE_ENGINE__THREADS=1 || exit 1

code=0
here=$PWD
# It leaves a cache where it runs.
(cd "$work" && "$here/target/tools/schemathesis/bin/st" --config-file "$here/tests/clients/schemathesis.toml" \
    run "$base/openapi.json" --max-examples "$cases" --no-color) >"$work/told" 2>&1 || code=$?
ran=$(sed -nE 's/^ *Test cases: *([0-9,]+) .*/\1/p; s/^ *([0-9,]+) generated.*/\1/p' "$work/told" | tr -d , | head -1)
if [ "$code" != 0 ] || [ "${ran:-0}" -lt "$least" ]; then
    tail -150 "$work/told"
    echo "schemathesis: exit $code after ${ran:-no} cases; at least $least are wanted"
    exit 1
fi
echo "schemathesis: $ran cases, no fault"
