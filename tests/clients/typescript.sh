#!/usr/bin/env bash
# Generates TypeScript types from the document that a running server serves, checks a client on them with the compiler, and
# runs a whole job through it.
#
#   tests/clients/typescript.sh BINARY
set -uo pipefail
binary=$(realpath "${1:?usage: tests/clients/typescript.sh BINARY}")
cd "$(dirname "$0")/../.." || exit 1
. tests/clients/server.sh

packages=(openapi-typescript@7.13.0 openapi-fetch@0.17.0 typescript@5.9.3 @types/node@20)
tool=target/tools/typescript
if [ "$(cat "$tool/installed" 2>/dev/null)" != "${packages[*]}" ]; then
    command -v npm >/dev/null || apt_install nodejs npm || exit 1
    rm -rf "$tool" && mkdir -p "$tool"
    npm install --silent --no-fund --no-audit --prefix "$tool" "${packages[@]}" || exit 1
    echo "${packages[*]}" >"$tool/installed"
fi
start_server "$binary" || exit 1

client=$tool/client
rm -rf "$client" && mkdir -p "$client"
curl -sf "$base/openapi.json" -o "$client/openapi.json" || exit 1
"$tool/node_modules/.bin/openapi-typescript" "$client/openapi.json" --default-non-nullable=false \
    -o "$client/api.ts" >"$work/generated" 2>&1 ||
    { cat "$work/generated"; exit 1; }
cp tests/clients/job.ts "$client/job.ts"
echo '{"type": "module"}' >"$client/package.json"
(cd "$client" && ../node_modules/.bin/tsc --strict --target es2022 --module nodenext --skipLibCheck --types node \
    --outDir out job.ts) || exit 1

"$binary" sample torus --triangles 3000 -o "$work/Ring é.obj" || exit 1
node "$client/out/job.js" "$base" "$work/Ring é.obj" || exit 1
